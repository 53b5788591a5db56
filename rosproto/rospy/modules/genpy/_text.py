"""strify_message: a message as the YAML that genpy prints, long strings folded as PyYAML folds them."""

import re

from rosproto.codec.text import _escaped
from rosproto.time import Time, TVal

WIDTH = 80  # PyYAML's


def strify_message(
    val, indent="", time_offset=None, current_time=None, field_filter=None, fixed_numeric_width=None
):
    """The text of a value; below the top level it begins on a line of its own where genpy's does."""
    from .message import Message

    def text_of(value, indent):
        kind = type(value)
        if kind in (int, float) and fixed_numeric_width is not None:
            return _fixed(value, fixed_numeric_width)
        if kind in (int, float, bool):
            return str(value)
        if isinstance(value, str):
            return double_quoted(value) if value else "''"
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
            return "\n" + "\n".join(indent + line for line in _string_lines(values))
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


def double_quoted(text):
    """A double-quoted YAML scalar, broken after column 80 at blanks or escapes, as yaml.dump writes it."""
    out, column = ['"'], 1
    start = end = 0
    while end <= len(text):
        char = text[end] if end < len(text) else None
        if char is None or char in '"\\' or not " " <= char <= "~":
            if start < end:
                out.append(text[start:end])
                column += end - start
                start = end
            if char is not None:
                escaped = "\\uFEFF" if char == "\ufeff" else _escaped(char)
                out.append(escaped)
                column += len(escaped)
                start = end + 1
        if 0 < end < len(text) - 1 and (char == " " or start >= end) and column + (end - start) > WIDTH:
            out.append(text[start:end] + "\\\n  ")
            start = max(start, end)
            column = 2
            if text[start] == " ":
                out.append("\\")
                column += 1
        end += 1
    out.append('"')
    return "".join(out)


_PLAIN = re.compile(r"[A-Za-z_./][A-Za-z0-9_./()+\-]*(?: [A-Za-z0-9_./()+\-]+)*\Z")
_WORDS = {"y", "n", "yes", "no", "true", "false", "on", "off", "null"}


def _string_lines(values):
    """Lines of a YAML list of strings; PyYAML writes them when it is there, else what is safe."""
    try:
        from yaml import dump
    except ImportError:
        return ["- " + _scalar(value) for value in values]
    return dump(list(values)).rstrip("\n").splitlines()


def _scalar(text):
    if _PLAIN.match(text) and text.lower() not in _WORDS and len(text) < WIDTH and not text.startswith("."):
        return text
    if all(" " <= char <= "~" for char in text) and len(text) < WIDTH:
        return "'" + text.replace("'", "''") + "'"
    return double_quoted(text)
