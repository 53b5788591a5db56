"""strify_message: a message as the YAML that genpy prints, long strings folded as PyYAML folds them."""

from rosproto.codec.text import double_quoted, list_item
from rosproto.time import Time, TVal


def strify_message(
    val, indent="", time_offset=None, current_time=None, field_filter=None, fixed_numeric_width=None
):
    """The text of a value; nested values start on a new line where they do in genpy."""
    from .message import Message

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
