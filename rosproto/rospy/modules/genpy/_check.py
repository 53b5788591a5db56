"""check_type: which value does not fit its field, in genpy's words."""

from rosproto.codec import Message as CodecMessage

from ._errors import SerializationError
from .rostime import Duration, Time

_SIGNED = {"byte": 8, "int8": 8, "int16": 16, "int32": 32, "int64": 64}
_UNSIGNED = {"char": 8, "uint8": 8, "uint16": 16, "uint32": 32, "uint64": 64}
_NUMPY_NUMBERS = {
    "float32",
    "float64",
    "int8",
    "int16",
    "int32",
    "int64",
    "uint8",
    "uint16",
    "uint32",
    "uint64",
}
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
