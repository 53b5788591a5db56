"""Encoding messages, with genpy's errors for those that cannot be encoded."""

import copy
import struct

from rosproto.codec import Message as CodecMessage
from rosproto.codec import encode
from rosproto.errors import CodecError

from ._fields import SerializationError

_REFUSED = (CodecError, TypeError, ValueError, AttributeError)
_BYTES = ("uint8", "char")
_WALKED = {"string": (str, dict)}


def encode_message(message):
    """Bytes of a message of either family.

    Raises:
        SerializationError: A value does not fit its field.
    """
    if not isinstance(message, CodecMessage):
        from io import BytesIO

        buffer = BytesIO()
        message.serialize(buffer)
        return buffer.getvalue()
    try:
        return encode(message)
    except _REFUSED:
        return encode(sendable(message))


def sendable(message):
    """A message that our codec can encode: itself, or a copy in which some values became tuples.

    Raises:
        SerializationError: A value does not fit its field.
    """
    try:
        encode(message)
    except _REFUSED as error:
        walked = _with_walked_fields(message)
        if walked is None:
            refuse(message, error)
        return sendable(walked)
    return message


def refuse(message, error):
    """Raise what genpy raises for a message that cannot be encoded."""
    _touch(message)
    if "out of range for float32" in str(error):  # genpy does not check the range there, struct does
        message._check_types()
        raise OverflowError("float too large to pack with f format")
    message._check_types(struct.error(error))
    raise SerializationError(str(error))


def _touch(value):
    """Read every field as genpy's code does: a value that is no message or no text is an AttributeError."""
    for name, type_ in zip(value.__slots__, value._slot_types):
        inner = getattr(value, name)
        base = type_.partition("[")[0]
        for one in _items(inner) if type_.endswith("]") else [inner]:
            if base == "string":
                if hasattr(one, "__len__"):
                    _ = one.encode
            elif base in ("time", "duration"):
                _ = one.secs
            elif _is_message(base):
                _touch_message(one, base)


def _touch_message(value, type_):
    from rosproto.rospy import messages

    for name in messages.message(type_).__slots__:
        getattr(value, name)
    if hasattr(value, "_slot_types"):
        _touch(value)


def _items(value):
    return value if isinstance(value, (list, tuple)) else ()


def _is_message(base):
    return "/" in base or base == "Header"


# -- values that genpy only iterates over -------------------------------------------------------------------


def _with_walked_fields(message):
    """A copy that can be encoded, of a message that gives bytes for numbers or a text for a list of texts.

    genpy iterates over any value that has a length: bytes give numbers, a text gives its letters.
    None for a message that has no such field.
    """
    if not any(True for _ in _walked_fields(message)):
        return None
    copied = copy.deepcopy(message)
    for owner, name in list(_walked_fields(copied)):
        setattr(owner, name, tuple(getattr(owner, name)))
    return copied


def _walked_fields(message):
    for name, type_ in zip(message.__slots__, message._slot_types):
        value = getattr(message, name)
        base, is_array, _ = type_.partition("[")
        if _is_message(base):
            for one in _items(value) if is_array else (value,):
                if isinstance(one, CodecMessage):
                    yield from _walked_fields(one)
        elif is_array and base not in _BYTES and isinstance(value, _WALKED.get(base, (bytes, bytearray))):
            yield message, name
