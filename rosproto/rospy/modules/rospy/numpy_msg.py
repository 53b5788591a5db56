"""numpy_msg: a message type whose arrays are numpy's."""

from rosproto.rospy.messages import is_ours

_made = {}


def numpy_msg(msg_type):
    """The type with numpy arrays in place of tuples and bytes; for Publisher and Subscriber."""
    if msg_type not in _made:
        _made[msg_type] = _of_definition(msg_type) if is_ours(msg_type) else _of_generated(msg_type)
    return _made[msg_type]


def _of_definition(msg_type):
    from genpy.message import numpy_class

    return numpy_class(msg_type)


def _of_generated(msg_type):
    """The same for a class that genpy generated, which has the two functions itself."""
    import numpy

    def serialize(self, buff):
        return self.serialize_numpy(buff, numpy)

    def deserialize(self, str):
        return self.deserialize_numpy(str, numpy)

    return type(
        "Numpy_%s" % msg_type._type.replace("/", "__"),
        (msg_type,),
        {"__slots__": msg_type.__slots__, "serialize": serialize, "deserialize": deserialize},
    )
