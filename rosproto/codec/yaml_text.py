"""Strings as YAML scalars with the styles and line breaks of PyYAML, as in genpy.

Fields are always double-quoted. List elements are plain if they read back as the same string, double-quoted
if they contain tabs or other characters than printable ASCII, else single-quoted. Lines break at the first
possible place after column 80. Source: the YAML 1.1 specification, chapters 5 and 7 and its types; PyYAML's
output, with which the tests compare.
"""

from __future__ import annotations

import re

WIDTH = 80
INDENT = "  "
_ESCAPES = {"\0": "0", "\a": "a", "\b": "b", "\t": "t", "\n": "n", "\v": "v", "\f": "f", "\r": "r"}
_ESCAPES.update({"\x1b": "e", '"': '"', "\\": "\\", "\x85": "N", "\xa0": "_", "\u2028": "L", "\u2029": "P"})
_PRINTABLE = re.compile(r"[ -~\n]*")
_OTHER_TYPES = re.compile(
    r"""  ~ | null | Null | NULL | = | <<
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
    """,
    re.VERBOSE,
)
"""Text that YAML 1.1 reads as a null, boolean, number, date or merge key."""
_INDICATES = re.compile(
    r"""[#,\[\]{}&*!|>'"%@`]|[-?:](?:\s|$)|---|\.\.\.|.*:(?:\s|$)|.*\s\#|\s|.*\s$""", re.DOTALL
)
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
    if not _PRINTABLE.fullmatch(text) or " \n" in text or "\n " in text:
        return double_quoted(text, column)
    if text and "\n" not in text and not _OTHER_TYPES.fullmatch(text) and not _INDICATES.match(text):
        return _folded(text, column)[0]
    return _single_quoted(text, column)


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
