"""Values of fields: which one does not fit (check_type), encoding them, and a message from values written as
YAML on a command line.

The errors have genpy's texts; tracebacks name them as part of genpy.message.
"""

import copy
import struct
from io import BytesIO

from rosproto.codec import Message as CodecMessage
from rosproto.codec import encode
from rosproto.errors import CodecError

from .base import SIMPLE_TYPES
from .rostime import Duration, Time, TVal


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


# -- messages from values written as YAML --------------------------------------------------------------------


def fill_message_args(msg, msg_args, keys={}):  # noqa: B006  genpy's signature
    """Fill a message from a list of values, or from a dict by field name.

    Raises:
        MessageException: A value is missing or of the wrong kind, or there is no such field.
    """
    if msg_args is None:
        msg_args = []
    if len(msg_args) == 1 and type(msg_args[0]) is dict:
        msg_args = msg_args[0]
    _fill(msg, msg_args, keys, "")


def _fill(msg, values, keys, prefix):
    from .message import Message

    if not isinstance(msg, (Message, TVal)):
        raise ValueError("msg must be a Message instance: %s" % msg)
    if type(values) is dict:
        pairs = [(name, "" if value is None else value) for name, value in values.items()]
    elif type(values) is list:
        slots = msg.__slots__
        if len(values) != len(slots):
            many = "Too many" if len(values) > len(slots) else "Not enough"
            raise MessageException("%s arguments:\n * Given: %s\n * Expected: %s" % (many, values, slots))
        pairs = zip(slots, values)
    else:
        raise ValueError("invalid msg_args type: %s" % str(values))
    for name, value in pairs:
        _fill_one(msg, name, value, keys, prefix)


def _fill_one(msg, name, value, keys, prefix):
    from .message import Message, get_message_class

    if name not in msg.__slots__:
        raise MessageException("No field name [%s%s]" % (prefix, name))
    present = getattr(msg, name)
    if isinstance(present, (Message, TVal)):
        setattr(msg, name, _filled(present, value, keys, prefix + name + "."))
        return
    if type(present) is not list:
        setattr(msg, name, value)
        return
    if type(value) not in (list, tuple):
        raise MessageException(
            "Field [%s%s] must be a list or tuple instead of: %s" % (prefix, name, type(value).__name__)
        )
    base, _, rest = msg._slot_types[list(msg.__slots__).index(name)].partition("[")
    length = rest.rstrip("]")
    if length and len(value) != int(length):
        raise MessageException(
            "Field [%s%s] has incorrect number of elements: %s != %s" % (prefix, name, len(value), length)
        )
    if "/" in base or base in ("time", "duration", "Header"):
        value = [_filled(get_message_class(base)(), item, keys, prefix) for item in value]
    setattr(msg, name, value)


def _filled(present, value, keys, prefix):
    if type(value) is str:
        if value not in keys:
            raise MessageException("No key named [%s]" % (value))
        return keys[value]
    if isinstance(present, TVal) and type(value) is int:
        return type(present).from_sec(value / 1e9)
    _fill(present, value, keys, prefix)
    return present
