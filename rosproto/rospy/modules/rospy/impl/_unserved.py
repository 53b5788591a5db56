"""Stand-ins for rospy's internals that programs import and that have no counterpart here."""


class Unserved(NotImplementedError):
    """A part of rospy was used that this layer does not have."""

    def __init__(self, name):
        super().__init__(
            "%s is a part of rospy's own connections, which are rosproto's here: use rospy.Publisher,"
            " Subscriber, Service and ServiceProxy, or for more rosproto.Node" % name
        )


def unserved(name, base=object):
    """A class or function that can be imported, derived from and used with isinstance; calling it raises."""

    def __init__(self, *args, **kwds):
        raise Unserved(name)

    module, _, own = name.rpartition(".")
    return type(own, (base,), {"__init__": __init__, "__module__": module})
