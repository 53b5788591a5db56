"""str(msg): the indented `name: value` text that genpy prints, which is YAML.

Strings have the styles and line breaks of PyYAML, as in genpy: fields are always double-quoted. List elements
are plain if they read back as the same string, double-quoted if they contain tabs or other characters than
printable ASCII, else single-quoted. Lines break at the first possible place after column 80. Source: the YAML
1.1 specification, chapters 5 and 7 and its types; PyYAML's output, with which the tests compare.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from typing import Any

from rosproto.codec.message import Message
from rosproto.time import TVal


def strify_message(value: object, indent: str = "", *, width: int | None = None) -> str:
    """A value as genpy's text; nested values begin on a new line where genpy's do.

    Unlike in genpy, fields are named as in the definition (`in`, not `in_`).

    Args:
        value: A message or a field's value.
        indent: Blanks before each line.
        width: Characters of each number, as genpy's fixed_numeric_width; None for no fixed width.
    """
    if isinstance(value, Message):
        return _message(value, indent, width)
    if isinstance(value, TVal):
        least = 9 if width is None else width
        return f"\n{indent}secs: {value.secs:{width or ''}d}\n{indent}nsecs: {value.nsecs:{least}d}"
    if isinstance(value, str):
        return double_quoted(value)
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


def _items(items: Sequence[Any], indent: str, width: int | None) -> str:
    if not items:
        return "[]"
    if isinstance(items[0], (int, float)):
        if width is None:
            return str(list(items))
        return "[" + ", ".join(_fixed(item, width) for item in items) + "]"
    if isinstance(items[0], str):
        lines = [line for item in items for line in f"- {list_item(item)}".split("\n")]
        return "".join(f"\n{indent}{line}" for line in lines)
    prefix = "\n" + indent + "- "
    return "".join(prefix + strify_message(item, indent + "  ", width=width) for item in items)


def _fixed(value: object, width: int) -> str:
    """Cut decimals to the width, but keep all digits before the point."""
    if isinstance(value, float):
        text = f"{value:.{width}f}"
        return text[: max(text.find("."), width)]
    return f"{value:{width}d}" if isinstance(value, int) and not isinstance(value, bool) else str(value)


def quoted(text: str) -> str:
    """A string as YAML in one line: double-quoted, or '' when empty."""
    return double_quoted(text, width=sys.maxsize)


# -- strings ------------------------------------------------------------------------------
# The patterns are compiled with their first use, which takes longer than importing the codec.

WIDTH = 80
INDENT = "  "
_ESCAPES = {"\0": "0", "\a": "a", "\b": "b", "\t": "t", "\n": "n", "\v": "v", "\f": "f", "\r": "r"}
_ESCAPES.update({"\x1b": "e", '"': '"', "\\": "\\", "\x85": "N", "\xa0": "_", "\u2028": "L", "\u2029": "P"})
_PRINTABLE = r"[ -~\n]*"
_OTHER_TYPES = r"""  ~ | null | Null | NULL | = | <<
    | (?:yes|Yes|YES|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF)
    | [-+]?(?:[0-9][0-9_]*)\.[0-9_]*(?:[eE][-+][0-9]+)?
    | \.[0-9][0-9_]*(?:[eE][-+][0-9]+)?
    | [-+]?[0-9][0-9_]*(?::[0-5]?[0-9])+\.[0-9_]*
    | [-+]?\.(?:inf|Inf|INF) | \.(?:nan|NaN|NAN)
    | [-+]?0b[0-1_]+ | [-+]?0[0-7_]+ | [-+]?(?:0|[1-9][0-9_]*) | [-+]?0x[0-9a-fA-F_]+
    | [-+]?[1-9][0-9_]*(?::[0-5]?[0-9])+
    | [0-9]{4}-[0-9]{2}-[0-9]{2}
    | [0-9]{4}-[0-9]{1,2}-[0-9]{1,2}(?:[Tt]|[ \t]+)[0-9]{1,2}:[0-9]{2}:[0-9]{2}(?:\.[0-9]*)?
      (?:[ \t]*(?:Z|[-+][0-9]{1,2}(?::[0-9]{2})?))?
    """
"""Text that YAML 1.1 reads as a null, boolean, number, date or merge key."""
_INDICATES = r"""(?s)[#,\[\]{}&*!|>'"%@`]|[-?:](?:\s|$)|---|\.\.\.|.*:(?:\s|$)|.*\s\#|\s|.*\s$"""
"""Text with YAML syntax at the beginning or inside."""


def double_quoted(text: str, column: int = 0, width: int = WIDTH) -> str:
    """A scalar in double quotes; '' when empty.

    Args:
        text: The string; lone surrogates become escapes.
        column: Column of its first character.
        width: Column after which a line may break.
    """
    if not text:
        return "''"
    written = ['"']
    column += 1
    start = 0
    last = len(text) - 1
    for end, char in enumerate([*text, ""]):
        if not char or char in _ESCAPES or not " " <= char <= "~":
            written.append(text[start:end])
            column += end - start
            start = end
            if char:
                escape = _escaped(char)
                written.append(escape)
                column += len(escape)
                start = end + 1
        if 0 < end < last and (char == " " or start >= end) and column + end - start > width:
            written.append(text[start:end] + "\\\n" + INDENT)
            start = max(start, end)
            column = len(INDENT)
            if text[start] == " ":
                written.append("\\")
                column += 1
    return "".join(written) + '"'


def list_item(text: str) -> str:
    """A scalar after `- `, in the simplest style that reads back as this string."""
    column = 2
    if not re.fullmatch(_PRINTABLE, text) or " \n" in text or "\n " in text:
        return double_quoted(text, column)
    if not text or "\n" in text or re.fullmatch(_OTHER_TYPES, text, re.VERBOSE) or re.match(_INDICATES, text):
        return _single_quoted(text, column)
    return _folded(text, column)[0]


def _single_quoted(text: str, column: int) -> str:
    """Quotes are doubled; each sequence of line breaks gets one more."""
    written = ["'"]
    column += 1
    pieces = re.split(r"(\n+)", text.replace("'", "''"))
    for index, piece in enumerate(pieces):
        if piece.startswith("\n"):
            written.append(f"{piece}\n{INDENT}")
            column = len(INDENT)
            continue
        # A blank next to a quotation mark is kept.
        first = " " if index == 0 and piece.startswith(" ") else ""
        last = " " if index == len(pieces) - 1 and piece.endswith(" ") and len(piece) > 1 else ""
        folded, column = _folded(piece[len(first) : len(piece) - len(last)], column + len(first))
        written.append(f"{first}{folded}{last}")
    return "".join(written) + "'"


def _folded(text: str, column: int) -> tuple[str, int]:
    """Break lines at single blanks; return the text and the next column."""
    written: list[str] = []
    for index, part in enumerate(re.split(r"(?<! ) (?! )", text)):
        if index:
            written.append("\n" + INDENT if column > WIDTH else " ")
            column = len(INDENT) if column > WIDTH else column + 1
        written.append(part)
        column += len(part)
    return "".join(written), column


def _escaped(char: str) -> str:
    if char in _ESCAPES:
        return "\\" + _ESCAPES[char]
    code = ord(char)
    if code <= 0xFF:
        return f"\\x{code:02X}"
    return f"\\u{code:04X}" if code <= 0xFFFF else f"\\U{code:08X}"
