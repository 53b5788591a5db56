"""rospy.msg: AnyMsg; converts the arguments of publish() to a message."""

import struct

import genpy

from .exceptions import ROSException, ROSSerializationException
from .names import TOPIC_ANYTYPE


class AnyMsg(genpy.Message):
    """A message of any type; `_buff` holds its encoded bytes."""

    _md5sum = TOPIC_ANYTYPE
    _type = TOPIC_ANYTYPE
    _has_header = False
    _full_text = ""
    _slot_types = []
    __slots__ = ["_buff"]

    def __init__(self, *args):
        if args:
            raise ROSException("AnyMsg does not accept arguments")
        self._buff = None

    def serialize(self, buff):
        """Write the encoded message to `buff`."""
        if self._buff is None:
            raise ROSException("AnyMsg is not initialized")
        buff.write(self._buff)

    def deserialize(self, str):
        """Store the encoded message; returns itself."""
        self._buff = str
        return self


def args_kwds_to_message(data_class, args, kwds):
    """Return the message of `publish(message)`, `publish(value, ...)` or `publish(field=value)`."""
    if args and kwds:
        raise TypeError("publish() can be called with arguments or keywords, but not both.")
    if kwds:
        return data_class(**kwds)
    if len(args) == 1:
        only = args[0]
        if hasattr(only, "_md5sum") and (only._md5sum == data_class._md5sum or isinstance(only, AnyMsg)):
            return only
        if isinstance(only, genpy.Message):
            types = data_class._slot_types
            if len(types) == 0:
                raise TypeError("expected [] but got [%s]" % only._type)
            if only._type != types[0]:
                raise TypeError("expected [%s] but got [%s]" % (types[0], only._type))
    return data_class(*args)


def deserialize_messages(b, msg_queue, data_class, queue_size=None, max_msgs=None, start=0):
    """Append the messages before the position of a buffer, each after its length; the rest stays there."""
    try:
        data, found = memoryview(b.getvalue())[start : b.tell()], []
        while len(data) >= 4 and len(found) != max_msgs:
            end = 4 + int.from_bytes(data[:4], "little")
            if len(data) < end:
                break
            found.append(data_class().deserialize(bytes(data[4:end])))
            data = data[end:]
        msg_queue += found
        del msg_queue[: -queue_size if queue_size else 0]
    except Exception as error:
        raise genpy.DeserializationError("cannot deserialize: %s" % error) from None
    if found:
        b.seek(start)
        b.truncate()
        b.write(data)


def serialize_message(b, seq, msg):
    """Write the message, preceded by its length, to a buffer."""
    if getattr(msg.__class__, "_has_header", False):
        msg.header.seq = seq
        if msg.header.frame_id is None:
            msg.header.frame_id = "0"
    start = b.tell()
    b.seek(start + 4)
    try:
        msg.serialize(b)
    except struct.error as error:
        raise ROSSerializationException(error) from None
    end = b.tell()
    b.seek(start)
    b.write(struct.pack("<I", end - start - 4))
    b.seek(end)
