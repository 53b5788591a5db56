"""genmsg.msgs: a message as MsgSpec, and what types there are."""

import re

from .base import InvalidMsgSpec
from .names import is_legal_resource_base_name, is_legal_resource_name, package_resource_name

HEADER, TIME, DURATION = "Header", "time", "duration"
HEADER_FULL_NAME = "std_msgs/Header"
TIME_MSG, DURATION_MSG = "uint32 secs\nuint32 nsecs", "int32 secs\nint32 nsecs"
PRIMITIVE_TYPES = (
    "int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64 string bool char byte".split()
)
BUILTIN_TYPES = [*PRIMITIVE_TYPES, TIME, DURATION]
_BRACKETS = re.compile(r"(\[\d*\])*")


def is_header_type(msg_type):
    """True for the header, by any of its names."""
    return msg_type in (HEADER, HEADER_FULL_NAME, "roslib/Header")


def is_builtin(msg_type_name):
    """True for a built-in type."""
    return msg_type_name in BUILTIN_TYPES


def bare_msg_type(msg_type):
    """The type without array brackets."""
    return None if msg_type is None else msg_type.partition("[")[0]


def resolve_type(msg_type, package_context):
    """The type with its package."""
    bare = bare_msg_type(msg_type)
    if bare == HEADER:
        return HEADER_FULL_NAME
    return msg_type if bare in BUILTIN_TYPES or "/" in msg_type else "%s/%s" % (package_context, msg_type)


def parse_type(msg_type):
    """(element type, whether it is an array, its fixed length or None)."""
    if not msg_type:
        raise ValueError("Invalid empty type")
    base, bracket, length = msg_type.partition("[")
    if "[" in length:
        raise ValueError("Currently only support 1-dimensional array types: %s" % msg_type)
    if not bracket or length == "]":
        return base, bool(bracket), None
    try:
        if not length.endswith("]"):  # genmsg would take the last digit for the bracket
            raise ValueError
        return base, True, int(length[:-1])
    except ValueError:
        raise ValueError("Invalid array dimension: [%s]" % length[:-1]) from None


def is_valid_msg_type(x):
    """True for the spelling of a type."""
    if not x or x != x.strip() or not is_legal_resource_name(bare_msg_type(x)):
        return False
    return bool(_BRACKETS.fullmatch(x, len(bare_msg_type(x))))


def is_valid_constant_type(x):
    """True for a type that constants may have."""
    return x in PRIMITIVE_TYPES


def is_valid_msg_field_name(x):
    """True for the spelling of a field's name."""
    return is_legal_resource_base_name(x)


class Equal:
    def __eq__(self, other):
        return type(other) is type(self) and vars(self) == vars(other)

    __hash__ = object.__hash__


class Constant(Equal):
    """A constant: `val` is its Python value, `val_text` the text in the definition."""

    def __init__(self, type_, name, val, val_text):
        if any(part is None for part in (type_, name, val, val_text)):
            raise ValueError("Constant must have non-None parameters")
        self.type, self.name, self.val, self.val_text = type_, name.strip(), val, val_text

    def __repr__(self):
        return "%s %s=%s" % (self.type, self.name, self.val)


class Field(Equal):
    """A field: its type as written, and in parts."""

    def __init__(self, name, type):
        self.name, self.type = name, type
        self.base_type, self.is_array, self.array_len = parse_type(type)
        self.is_header = is_header_type(type)
        self.is_builtin = is_builtin(self.base_type)

    def __repr__(self):
        return "[%s, %s, %s, %s, %s]" % (
            self.name, self.type, self.base_type, self.is_array, self.array_len
        )  # fmt: skip


class MsgSpec(Equal):
    """A message: `types` and `names` of its fields, its constants, its text."""

    def __init__(self, types, names, constants, text, full_name, package="", short_name=""):
        if len(set(names)) != len(names):
            raise InvalidMsgSpec("Duplicate field names in message: %s" % names)
        assert len(types) == len(names), "len(%s) != len(%s)" % (types, names)
        own_package, own_name = package_resource_name(full_name)
        self.types, self.names, self.constants, self.text = types, names, constants, text
        self.full_name, self.package, self.short_name = (
            full_name,
            package or own_package,
            short_name or own_name,
        )
        self.header_present = bool(types) and (types[0], names[0]) == (HEADER_FULL_NAME, "header")
        try:
            self._parsed_fields = [Field(name, type_) for name, type_ in zip(names, types)]
        except ValueError as error:
            raise InvalidMsgSpec("invalid field: %s" % error) from None

    def fields(self):
        """[(type, name)]."""
        return list(zip(self.types, self.names))

    def parsed_fields(self):
        """The fields as `Field` objects."""
        return self._parsed_fields

    def has_header(self):
        """True when the first field is `Header header`."""
        return self.header_present

    def __repr__(self):
        parts = [self.constants] if self.constants else []
        return "MsgSpec[%s]" % ", ".join(map(repr, [*parts, self.types, self.names]))

    def __str__(self):
        return self.text
