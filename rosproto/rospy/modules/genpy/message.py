"""genpy.message: the bases of message classes, what they refuse to send, and how they print.

Two families are messages here. Classes that genpy generated derive from `Message`, a plain class. Classes
made from definitions derive from `RosMessage`, which is our codec's with genpy's manners. `isinstance(x,
Message)` holds for both.
"""

import codecs
import logging
import struct

from rosproto.codec import Flavour
from rosproto.codec import Message as CodecMessage
from rosproto.codec.flavour import flavour_named
from rosproto.codec.message import MessageMeta
from rosproto.errors import CodecError

from ._check import check_type
from ._errors import DeserializationError, MessageException, SerializationError
from ._text import strify_message
from .rostime import Duration, Time, TVal

__all__ = [
    "FLAVOUR",
    "NUMPY_FLAVOUR",
    "DeserializationError",
    "Message",
    "MessageException",
    "RosMessage",
    "SerializationError",
    "check_type",
    "fill_message_args",
    "get_message_class",
    "get_printable_message_args",
    "get_service_class",
    "strify_message",
    "struct_I",
]

struct_I = struct.Struct("<I")


class RosMsgUnicodeErrors:
    """The codec error handler "rosmsg": text that is not UTF-8 is replaced, and told once per type."""

    def __init__(self):
        self.msg_type = None
        self._told = set()

    def __call__(self, error):
        if self.msg_type not in self._told:
            self._told.add(self.msg_type)
            what = "message %s" % self.msg_type if self.msg_type else "unknown message"
            logging.getLogger("rosout").error(
                "Characters replaced when decoding %s (will print only once): %s", what, error
            )
        return codecs.replace_errors(error)


codecs.register_error("rosmsg", RosMsgUnicodeErrors())


class _EitherFamily(type):
    def __instancecheck__(cls, instance):
        return type.__instancecheck__(cls, instance) or (
            cls is Message and isinstance(instance, CodecMessage)
        )

    def __subclasscheck__(cls, other):
        return type.__subclasscheck__(cls, other) or (cls is Message and issubclass(other, CodecMessage))


def _assign(self, slots, args, kwds, default=None):
    """Values by position or by name, as genpy's constructors take them; None is left for the default."""
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
    """What both families have."""

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


class _RosMeta(MessageMeta):
    """Constructors with genpy's texts, `__module__` of the file that genpy would have generated."""

    def __new__(mcs, name, bases, namespace, **kwds):
        type_ = namespace.get("_type")
        if type_ and "_binding" in namespace:
            base, where = type_.partition("/")[2], namespace["__module__"]
            if where.endswith(".srv"):
                base = base.removesuffix("Request").removesuffix("Response")
            namespace["__module__"] = "%s._%s" % (where, base)
        return super().__new__(mcs, name, bases, namespace, **kwds)

    def __instancecheck__(cls, instance):
        # A message with numpy arrays is one of its type all the same.
        kind = type(instance)
        return issubclass(kind, cls) or getattr(kind, "_tuple_class", None) is cls

    def __call__(cls, *args, **kwds):
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

    def __init__(self, *args, **kwds):
        # The metaclass has done it; this is for `super().__init__(...)` in a program's subclass.
        if args or kwds:
            _assign(self, self.__slots__, args, kwds)

    def _get_types(self):
        return list(self._slot_types)

    def serialize(self, buff):
        """Write the encoded message to `buff`."""
        buff.write(encode_message(self))

    def deserialize(self, str):
        """Take the values from encoded bytes; returns this message."""
        try:
            return CodecMessage.deserialize(self, str)
        except CodecError as error:
            raise DeserializationError(error) from None

    def serialize_numpy(self, buff, numpy):
        """As `serialize`; arrays may be numpy's in any case."""
        self.serialize(buff)

    def deserialize_numpy(self, str, numpy):
        """As `deserialize`, with numpy arrays."""
        return numpy_class(type(self))().deserialize(str)

    __eq__ = _Checked.__eq__
    __hash__ = None
    __str__ = _Checked.__str__
    __repr__ = _Checked.__repr__
    __getstate__ = _Checked.__getstate__

    def __setstate__(self, state):
        _Checked.__setstate__(self, state)
        self._connection_header = None

    __reduce__ = object.__reduce__  # pickled by the name of the class, as genpy's are


def encode_message(message):
    """Bytes of a message of either family.

    Raises:
        SerializationError: A value does not fit its field.
    """
    if isinstance(message, CodecMessage):
        try:
            return type(message)._encode(message)
        except (CodecError, TypeError, ValueError, AttributeError) as error:
            refuse(message, error)
    from io import BytesIO

    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def refuse(message, error):
    """Raise what genpy raises for a message that cannot be encoded."""
    _touch(message)
    if "out of range for float32" in str(error):  # genpy looks at no range there, struct does
        message._check_types()
        raise OverflowError("float too large to pack with f format")
    message._check_types(struct.error(error))
    raise SerializationError(str(error))


def _touch(value):
    """Read every field as genpy's code does: one that is no message or text at all is an AttributeError."""
    for name, type_ in zip(value.__slots__, value._slot_types):
        inner = getattr(value, name)
        base = type_.partition("[")[0]
        for one in _items(inner) if type_.endswith("]") else [inner]:
            if base == "string":
                if hasattr(one, "__len__"):
                    _ = one.encode
            elif base in ("time", "duration"):
                _ = one.secs
            elif "/" in base or base == "Header":
                _touch_message(one, base)


def _items(value):
    return value if isinstance(value, (list, tuple)) else ()


def _touch_message(value, type_):
    from rosproto.rospy import messages

    for name in messages.message(type_).__slots__:
        getattr(value, name)
    if hasattr(value, "_slot_types"):
        _touch(value)


FLAVOUR = Flavour(
    "rospy",
    views=False,
    base=RosMessage,
    time=Time,
    duration=Duration,
    module="{package}.{kind}",
    text_errors="rosmsg",
)
NUMPY_FLAVOUR = Flavour(
    "rospy-numpy",
    views=True,
    base=RosMessage,
    time=Time,
    duration=Duration,
    module="{package}.{kind}",
    text_errors="rosmsg",
)
flavour_named(FLAVOUR)
flavour_named(NUMPY_FLAVOUR)


def numpy_class(cls):
    """The class of the same type whose arrays are numpy's."""
    from rosproto.codec import message_class

    made = message_class(cls._spec, cls._binding.library, flavour=NUMPY_FLAVOUR)
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
    from importlib import import_module

    try:
        return getattr(import_module("%s.%s" % (package, kind)), base, None)
    except ImportError:
        return None


def fill_message_args(msg, msg_args, keys={}):  # noqa: B006  genpy's signature
    """Fill a message from what YAML on a command line gives: a list of values, or a dict by field name."""
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
