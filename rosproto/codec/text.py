"""str(msg): the indented `name: value` text that genpy prints, which is YAML."""

from __future__ import annotations

from typing import Any

from rosproto.codec.message import Message
from rosproto.time import TVal

__all__ = ["strify_message"]


def strify_message(value: Any, indent: str = "") -> str:
    """A value as text; below the top level it begins on a line of its own where genpy's does.

    Differences to genpy: long strings are not folded, and lists of strings are always double-quoted.
    """
    if isinstance(value, Message):
        return _message(value, indent)
    if isinstance(value, TVal):
        return f"\n{indent}secs: {value.secs}\n{indent}nsecs: {value.nsecs:9d}"
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, (bytes, bytearray)):
        return str(list(value))
    if hasattr(value, "tolist") and hasattr(value, "dtype"):
        return str(value.tolist())
    if isinstance(value, (list, tuple)):
        return _items(value, indent)
    return str(value)


def _message(message: Message, indent: str) -> str:
    lines = "\n".join(
        f"{indent}{name}: {strify_message(getattr(message, name, None), '  ' + indent)}"
        for name in message.__slots__
    )
    return "\n" + lines if indent else lines


def _items(items: Any, indent: str) -> str:
    if not items:
        return "[]"
    if isinstance(items[0], (int, float)):
        return str(list(items))
    prefix = "\n" + indent + "- "
    return "".join(prefix + strify_message(item, indent + "  ") for item in items)


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
