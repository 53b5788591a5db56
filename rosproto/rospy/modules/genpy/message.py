"""genpy.message: the bases of message classes, and where classes are found by their name.

There are two kinds of messages. Classes that genpy generated derive from `Message`, a plain class. Classes
made from definitions derive from `RosMessage`, our codec's base with genpy's behaviour. `isinstance(x,
Message)` holds for both.
"""

import codecs
import logging
import struct
import sys
from importlib import import_module

from rosproto.codec import Message as CodecMessage
from rosproto.codec import ValueStyle, message_class
from rosproto.codec.classes import restore
from rosproto.codec.layout import attribute_name
from rosproto.codec.message import MessageMeta
from rosproto.codec.text import double_quoted, list_item
from rosproto.codec.value_style import value_style_named
from rosproto.errors import CodecError
from rosproto.rospy.finder import library

from ._values import (
    DeserializationError,
    MessageException,
    SerializationError,
    check_type,
    encode_message,
    sendable,
)
from .rostime import Duration, Time, TVal

struct_I = struct.Struct("<I")


class RosMsgUnicodeErrors:
    """The codec error handler "rosmsg": text that is not UTF-8 is replaced, and reported once per type.

    Attributes:
        msg_type: The type that a generated class says it decodes.
    """

    def __init__(self):
        self.msg_type = None
        self._warned = set()

    def __call__(self, error):
        msg_type = _decoded_type(sys._getframe(1).f_code.co_filename) or self.msg_type
        if msg_type not in self._warned:
            self._warned.add(msg_type)
            what = "message %s" % msg_type if msg_type else "unknown message"
            logging.getLogger("rosout").error(
                "Characters replaced when decoding %s (will print only once): %s", what, error
            )
        return codecs.replace_errors(error)


def _decoded_type(filename):
    """The type that a function of our codec decodes; "" for any other function."""
    words = filename.strip("<>").split()
    return words[2] if words[:2] == ["rosproto", "decode"] else ""


codecs.register_error("rosmsg", RosMsgUnicodeErrors())


class _EitherFamily(type):
    def __instancecheck__(cls, instance):
        return type.__instancecheck__(cls, instance) or (
            cls is Message and isinstance(instance, CodecMessage)
        )

    def __subclasscheck__(cls, other):
        return type.__subclasscheck__(cls, other) or (cls is Message and issubclass(other, CodecMessage))


def _assign(self, slots, args, kwds):
    """Assign values by position or by name, as genpy's constructors do; None keeps the default."""
    if args and kwds:
        raise TypeError("Message constructor may only use args OR keywords, not both")
    if args:
        if len(args) != len(slots):
            raise TypeError(
                "Invalid number of arguments, args should be %s" % str(slots) + " args are" + str(args)
            )
        kwds = dict(zip(slots, args))
    else:
        for name in kwds:
            if name not in slots:
                raise AttributeError("%s is not an attribute of %s" % (name, self.__class__.__name__))
    for name, value in kwds.items():
        if value is not None:
            setattr(self, name, value)


class _Checked:
    """What both kinds of messages share."""

    __slots__ = ()

    def _check_types(self, exc=None):
        """Raise SerializationError for the first field whose value does not fit; else for `exc`."""
        for name, type_ in zip(self.__slots__, self._get_types()):
            check_type(name, type_, getattr(self, name))
        if exc:
            raise SerializationError(str(exc))

    def __repr__(self):
        return strify_message(self)

    def __str__(self):
        return strify_message(self)

    def __eq__(self, other):
        if not isinstance(other, self.__class__):
            return False
        for name in self.__slots__:
            try:
                ours, theirs = getattr(self, name), getattr(other, name)
            except AttributeError:
                return False
            if type(ours) in (list, tuple) and type(theirs) in (list, tuple):
                if tuple(ours) != tuple(theirs):
                    return False
            elif not ours == theirs:
                return False
        return True

    def __ne__(self, other):
        return not self == other

    __hash__ = None

    def __getstate__(self):
        return [getattr(self, name) for name in self.__slots__]

    def __setstate__(self, state):
        for name, value in zip(self.__slots__, state):
            setattr(self, name, value)


class Message(_Checked, metaclass=_EitherFamily):
    """Base of generated message classes."""

    __slots__ = ["_connection_header"]

    def __init__(self, *args, **kwds):
        _assign(self, self.__slots__, args, kwds)
        for name in self.__slots__:
            if not hasattr(self, name):
                setattr(self, name, None)

    def _get_types(self):
        raise Exception("must be overriden")

    def serialize(self, buff):
        """Write the encoded message to `buff`."""

    def deserialize(self, str_):
        """Take the values from encoded bytes."""


def _rename(cls, spec):
    """Spell reserved names as genpy does: a field `in` is `in_`, in texts and as keyword."""
    names = [field.name for field in spec.fields]
    renamed = [attribute_name(name, names) for name in names]
    if renamed != names:
        type.__setattr__(cls, "__slots__", renamed)
    for constant in spec.constants:
        if attribute_name(constant.name, names) != constant.name:
            type.__setattr__(cls, attribute_name(constant.name, names), constant.value)


class _RosMeta(MessageMeta):
    """Constructors with genpy's texts, `__module__` of the file that genpy would have generated."""

    def __new__(mcs, name, bases, namespace, **kwds):
        type_ = namespace.get("_type")
        if type_ and "_binding" in namespace:
            base, where = type_.partition("/")[2], namespace["__module__"]
            if where.endswith(".srv"):
                base = base.removesuffix("Request").removesuffix("Response")
            namespace["__module__"] = "%s._%s" % (where, base)
        made = super().__new__(mcs, name, bases, namespace, **kwds)
        if type_ and "_binding" in namespace:
            _rename(made, namespace["_spec"])
        return made

    def __instancecheck__(cls, instance):
        # A message with numpy arrays is still a message of its type.
        kind = type(instance)
        return issubclass(kind, cls) or getattr(kind, "_tuple_class", None) is cls

    def __call__(cls, /, *args, **kwds):
        self = object.__new__(cls)
        init = cls.__init__
        if init is not RosMessage.__init__:  # a program's own subclass
            cls._fill(self)
            init(self, *args, **kwds)
            return self
        if not args or any(arg is None for arg in args):
            cls._fill(self)
        else:
            self._connection_header = None
        if args or kwds:
            _assign(self, cls.__slots__, args, kwds)
        return self


class RosMessage(_Checked, CodecMessage, metaclass=_RosMeta):
    """Base of the classes made from definitions."""

    __slots__ = ()
    _tuple_class = None  # of a class with numpy arrays: the class of the same type with tuples

    def __init__(self, *args, **kwds):
        # The metaclass fills the message; this is for `super().__init__(...)` in a program's subclass.
        if args or kwds:
            _assign(self, self.__slots__, args, kwds)

    def _get_types(self):
        return list(self._slot_types)

    def serialize(self, buff):
        """Write the encoded message to `buff`."""
        buff.write(encode_message(self))

    def deserialize(self, str):
        """Take the values from encoded bytes; returns this message. Bytes after the message are ignored."""
        try:
            return CodecMessage.deserialize(self, str)
        except CodecError as error:
            if error.field_path or error.offset is None:
                raise DeserializationError(error) from None
            return CodecMessage.deserialize(self, str[: error.offset])

    def serialize_numpy(self, buff, numpy):
        """As `serialize`; arrays may be numpy's in any case."""
        self.serialize(buff)

    def deserialize_numpy(self, str, numpy):
        """As `deserialize`, with numpy arrays."""
        return numpy_class(type(self))().deserialize(str)

    def __setstate__(self, state):
        _Checked.__setstate__(self, state)
        self._connection_header = None

    def __reduce_ex__(self, protocol):
        """By the name of the class, as genpy's; for a class of a bag's definition, by that and the bytes."""
        binding = self._binding
        if type(self) is binding.cls and binding.library is not library():
            found = self._type, self._md5sum, self._full_text, binding.value_style.name
            return _restored, (*found, encode_message(self))
        return object.__reduce_ex__(self, protocol)

    __reduce__ = object.__reduce__  # which object.__reduce_ex__ takes for not overridden


def _restored(type_, md5sum, full_text, style, data):
    """A message of a definition. Importing this module makes the styles known."""
    message = restore(type_, md5sum, full_text, style)
    message.deserialize(data)
    return message


def _style(name, views):
    style = ValueStyle(
        name,
        views=views,
        base=RosMessage,
        time=Time,
        duration=Duration,
        module="{package}.{kind}",
        text_errors="rosmsg",
    )
    return value_style_named(style)  # pickles name it


FLAVOUR, NUMPY_FLAVOUR = _style("rospy", views=False), _style("rospy-numpy", views=True)


def numpy_class(cls):
    """The class of the same type whose arrays are numpy's."""
    made = message_class(cls._spec, cls._binding.library, value_style=NUMPY_FLAVOUR)
    if made is not cls:
        made.__name__ = made.__qualname__ = "Numpy_%s" % cls._type.replace("/", "__")
        made._tuple_class = cls
    return made


def get_printable_message_args(msg, buff=None, prefix=""):
    """Field names of a message, nested ones with dots, separated by blanks."""
    names = []
    for name in msg.__slots__:
        value = getattr(msg, name)
        if isinstance(value, Message):
            names.append(get_printable_message_args(value, prefix=prefix + name + "."))
        else:
            names.append(prefix + name)
    text = " ".join(names)
    if buff is not None:
        buff.write(text)
    return text


def get_message_class(message_type, reload_on_error=False):
    """The class of "package/Type", None when there is none."""
    return _find("msg", message_type)


def get_service_class(service_type, reload_on_error=False):
    """The service class of "package/Type", None when there is none."""
    return _find("srv", service_type)


def _find(kind, name):
    if name in ("time", "duration"):
        return Time if name == "time" else Duration
    package, slash, base = name.partition("/")
    if not slash:
        if name != "Header":
            raise ValueError("message type is missing package name: %s" % str(name))
        package, base = "std_msgs", name
    try:
        return getattr(import_module("%s.%s" % (package, kind)), base, None)
    except ImportError:
        return None


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


# -- texts ---------------------------------------------------------------------------------------------------


def strify_message(
    val, indent="", time_offset=None, current_time=None, field_filter=None, fixed_numeric_width=None
):
    """The text of a value; nested values start on a new line where they do in genpy."""

    def text_of(value, indent):
        kind = type(value)
        if kind in (int, float) and fixed_numeric_width is not None:
            return _fixed(value, fixed_numeric_width)
        if kind in (int, float, bool):
            return str(value)
        if isinstance(value, str):
            return double_quoted(value)
        if isinstance(value, TVal):
            return _time(value, indent)
        if kind in (list, tuple):
            return _items(value, indent)
        if isinstance(value, Message):
            return _message(value, indent)
        return str(value)

    def _time(value, indent):
        if time_offset is not None and isinstance(value, Time):
            value = value - time_offset
        if fixed_numeric_width is not None:
            secs, nsecs = (_fixed(part, fixed_numeric_width) for part in (value.secs, value.nsecs))
            return "\n%ssecs: %s\n%snsecs: %s" % (indent, secs, indent, nsecs)
        return "\n%ssecs: %s\n%snsecs: %9d" % (indent, value.secs, indent, value.nsecs)

    def _items(values, indent):
        if len(values) == 0:
            return "[]"
        first = values[0]
        if type(first) in (int, float) and fixed_numeric_width is not None:
            return "[" + ", ".join(text_of(value, indent) for value in values) + "]"
        if isinstance(first, str):
            lines = [line for value in values for line in ("- " + list_item(value)).split("\n")]
            return "\n" + "\n".join(indent + line for line in lines)
        if type(first) in (int, float, bool):
            return str(list(values))
        return "\n" + "\n".join(indent + "- " + text_of(value, indent + "  ") for value in values)

    def _message(message, indent):
        names = message.__slots__ if field_filter is None else list(field_filter(message))
        lines = "\n".join(
            "%s%s: %s" % (indent, name, text_of(_field(message, name, type_), "  " + indent))
            for name, type_ in zip(message.__slots__, message._slot_types)
            if name in names
        )
        return "\n" + lines if indent else lines

    return text_of(val, indent)


def _fixed(value, width):
    if type(value) is float:
        text = ("%." + str(width) + "f") % value
        return text[: max(text.find("."), width)]
    return ("%" + str(width) + "d") % value


def _field(message, name, type_):
    value = getattr(message, name)
    if "uint8[" in type_:
        if isinstance(value, str):
            return [ord(char) for char in value]
        if isinstance(value, bytes):
            return list(value)
    return value
