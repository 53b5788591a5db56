"""str(msg): the indented `name: value` text that genpy prints, which is YAML."""

from __future__ import annotations

from typing import Any

from rosproto.codec.message import Message
from rosproto.time import TVal

__all__ = ["strify_message"]


def strify_message(value: Any, indent: str = "", *, width: int | None = None) -> str:
    """A value as text; below the top level it begins on a line of its own where genpy's does.

    Differences to genpy: long strings are not folded, and lists of strings are always double-quoted.

    Args:
        value: A message, or what a field of one holds.
        indent: Blanks before each line.
        width: Characters that numbers take, as genpy's fixed_numeric_width; None: as many as they need.
    """
    if isinstance(value, Message):
        return _message(value, indent, width)
    if isinstance(value, TVal):
        least = 9 if width is None else width
        return f"\n{indent}secs: {value.secs:{width or ''}d}\n{indent}nsecs: {value.nsecs:{least}d}"
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, (bytes, bytearray)):
        value = list(value)
    if hasattr(value, "tolist") and hasattr(value, "dtype"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return _items(value, indent, width)
    return str(value) if width is None else _fixed(value, width)


def _message(message: Message, indent: str, width: int | None) -> str:
    lines = "\n".join(
        f"{indent}{name}: {strify_message(getattr(message, name, None), '  ' + indent, width=width)}"
        for name in message.__slots__
    )
    return "\n" + lines if indent else lines


def _items(items: Any, indent: str, width: int | None) -> str:
    if not items:
        return "[]"
    if isinstance(items[0], (int, float)):
        if width is None:
            return str(list(items))
        return "[" + ", ".join(_fixed(item, width) for item in items) + "]"
    prefix = "\n" + indent + "- "
    return "".join(prefix + strify_message(item, indent + "  ", width=width) for item in items)


def _fixed(value: Any, width: int) -> str:
    """As many digits as fit, but no digit before the point is lost."""
    if isinstance(value, float):
        text = f"{value:.{width}f}"
        return text[: max(text.find("."), width)]
    return f"{value:{width}d}" if isinstance(value, int) and not isinstance(value, bool) else str(value)


_ESCAPES = {"\0": "0", "\a": "a", "\b": "b", "\t": "t", "\n": "n", "\v": "v", "\f": "f", "\r": "r"}
_ESCAPES.update({"\x1b": "e", '"': '"', "\\": "\\", "\x85": "N", "\xa0": "_", "\u2028": "L", "\u2029": "P"})


def quoted(text: str) -> str:
    """A YAML scalar: '' or double-quoted, escaped as PyYAML does."""
    if not text:
        return "''"
    return '"' + "".join(map(_escaped, text)) + '"'


def _escaped(char: str) -> str:
    if char in _ESCAPES:
        return "\\" + _ESCAPES[char]
    code = ord(char)
    if 0x20 <= code < 0x7F:
        return char
    if code <= 0xFF:
        return f"\\x{code:02X}"
    return f"\\u{code:04X}" if code <= 0xFFFF else f"\\U{code:08X}"
