"""Values of fields: which one does not fit (check_type), and encoding them.

The errors have genpy's texts; tracebacks name them as part of genpy.message.
"""

import copy
import struct
from io import BytesIO

from rosproto.codec import Message as CodecMessage
from rosproto.codec import encode
from rosproto.errors import CodecError

from .base import SIMPLE_TYPES
from .rostime import Duration, Time


class MessageException(Exception):
    """Base of the others."""


class DeserializationError(MessageException):
    """Bytes and definition disagree."""


class SerializationError(MessageException):
    """A value does not fit its field."""


for _error in (MessageException, DeserializationError, SerializationError):
    _error.__module__ = "genpy.message"


_SIGNED = {"byte": 8, "int8": 8, "int16": 16, "int32": 32, "int64": 64}
_UNSIGNED = {"char": 8, "uint8": 8, "uint16": 16, "uint32": 32, "uint64": 64}
_NUMPY_NUMBERS = set(SIMPLE_TYPES) - {"bool", "byte", "char"}
_HEADERS = ("Header", "std_msgs/Header", "roslib/Header")


def check_type(field_name, field_type, field_val):
    """Raise SerializationError unless the value fits."""
    if field_type.endswith("]"):
        _check_array(field_name, field_type[: field_type.index("[")], field_val)
    elif field_type in _SIGNED:
        if type(field_val) is not int:
            raise SerializationError("field %s must be an integer type" % field_name)
        limit = 1 << (_SIGNED[field_type] - 1)
        if not -limit <= field_val < limit:
            raise SerializationError("field %s exceeds specified width [%s]" % (field_name, field_type))
    elif field_type in _UNSIGNED:
        if type(field_val) is not int or field_val < 0:
            raise SerializationError("field %s must be unsigned integer type" % field_name)
        if field_val >= 1 << _UNSIGNED[field_type]:
            raise SerializationError("field %s exceeds specified width [%s]" % (field_name, field_type))
    elif field_type in ("float32", "float64"):
        if not _is_number(field_val):
            raise SerializationError("field %s must be float type" % field_name)
    elif field_type == "bool":
        if field_val not in [True, False, 0, 1]:
            raise SerializationError("field %s is not a bool" % field_name)
    elif field_type == "string":
        _check_string(field_name, field_val)
    elif field_type == "time":
        if not isinstance(field_val, Time):
            raise SerializationError("field %s must be of type Time" % field_name)
    elif field_type == "duration":
        if not isinstance(field_val, Duration):
            raise SerializationError("field %s must be of type Duration" % field_name)
    else:
        _check_message(field_name, field_type, field_val)


def _is_number(value):
    kind = type(value)
    return kind in (float, int) or (kind.__module__ == "numpy" and kind.__name__ in _NUMPY_NUMBERS)


def _check_string(name, value):
    if type(value) is str:
        if not value.isascii():
            raise SerializationError("field %s is a non-ascii string" % name)
    elif type(value) is not bytes:
        raise SerializationError("field %s must be of type bytes or an ascii string" % name)


def _check_array(name, base, value):
    if type(value) in (bytes, str):
        if base not in ("char", "uint8"):
            raise SerializationError(
                "field %s must be a list or tuple type. Only uint8[] can be a string" % name
            )
        return
    if type(value) not in (list, tuple):
        raise SerializationError("field %s must be a list or tuple type" % name)
    for item in value:
        check_type(name + "[]", base, item)


def _check_message(name, expected, value):
    from .message import Message

    if not isinstance(value, (Message, CodecMessage)):
        raise SerializationError("field %s must be of type [%s]" % (name, expected))
    if value._type in _HEADERS:
        if expected not in _HEADERS:
            raise SerializationError("field %s must be a Header instead of a %s" % (name, value._type))
    elif value._type != expected:
        raise SerializationError("field %s must be of type %s instead of %s" % (name, expected, value._type))
    for inner, type_ in zip(value.__slots__, value._get_types()):
        check_type("%s.%s" % (name, inner), type_, getattr(value, inner))


# -- encoding, with genpy's errors for messages that cannot be encoded ---------------------------------------

_REFUSED = (CodecError, TypeError, ValueError, AttributeError)
_BYTES = ("uint8", "char")
_WALKED = {"string": (str, dict)}


def encode_message(message):
    """Bytes of a message of either family.

    Raises:
        SerializationError: A value does not fit its field.
    """
    if not isinstance(message, CodecMessage):
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
