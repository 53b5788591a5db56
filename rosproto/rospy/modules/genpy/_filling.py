"""fill_message_args: a message from values written as YAML on a command line."""

from ._errors import MessageException
from .rostime import TVal


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
