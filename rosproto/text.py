"""Make foreign text safe for a terminal and a log, and measure how many columns a text takes.

Text from a peer (a name, an error, a type, a frame) may contain what a terminal obeys: escape sequences that
move the cursor, rename the window or answer as if typed; a line feed that forges a log line; characters that
reverse the direction of writing or are invisible. In Unicode all of these are not printable, so no list of
them is needed.

Everything that is not printable becomes an escape as in Python and YAML (`\\x1b`, `\\u202e`, `\\n`). Letters
of any language and all kinds of blanks stay.

Chinese characters take two columns each.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

__all__ = ["cut", "human_bytes", "near_names", "padded", "printable", "short", "width", "wrapped"]

_BLANKS = frozenset(
    "\xa0\u1680\u2000\u2001\u2002\u2003\u2004\u2005\u2006\u2007\u2008\u2009\u200a\u202f\u205f\u3000"
)
"""Category Zs: of these, `str.isprintable` accepts only the ASCII blank."""
_PIECE = re.compile(r"(?:[（“《]*(?:[^\s\u2e80-\uffff]+|[\u2e80-\uffff])|\S)[，。；：、？！）”》]*\s*")
"""A word or a Chinese character, with the punctuation that must stay beside it."""
_SHORT = {"\n": "\\n", "\r": "\\r", "\t": "\\t"}


def printable(text: str, *, keep: str = "") -> str:
    """Escape everything that a terminal would obey or not show.

    Args:
        text: From a peer, a bag, a file.
        keep: Characters that are not escaped: `"\\n"` where lines are allowed, `"\\n\\t"` for tables.

    Returns:
        The text itself if there is nothing to escape.
    """
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() or c in keep or c in _BLANKS else _SHORT.get(c) or _escape(ord(c)) for c in text
    )


def _escape(code: int) -> str:
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def short(text: str, limit: int = 60) -> str:
    """The text; if it has more than `limit` characters, its beginning and "...", together `limit`."""
    return text if len(text) <= limit else f"{text[: limit - 3]}..."


def width(text: str) -> int:
    """Columns that a text takes; combining characters take none."""
    return len(text) if text.isascii() else sum(map(_columns, text))


def padded(text: str, columns: int) -> str:
    """The text padded with blanks to a number of columns, as `str.ljust` does for characters."""
    return text + " " * max(0, columns - width(text))


def cut(text: str, columns: int) -> str:
    """The beginning of the text that fits into a number of columns."""
    if text.isascii():
        return text[: max(0, columns)]
    taken = 0
    for index, character in enumerate(text):
        taken += _columns(character)
        if taken > columns:
            return text[:index]
    return text


def wrapped(text: str, columns: int) -> list[str]:
    """The text in lines of at most so many columns, broken at blanks and between Chinese characters."""
    lines = [""]
    for piece in _PIECE.findall(text):
        if width(lines[-1] + piece.rstrip()) > columns and lines[-1]:
            lines[-1] = lines[-1].rstrip()
            lines.append("")
        lines[-1] += piece if lines[-1] else piece.lstrip()
    return lines


def _columns(character: str) -> int:
    import unicodedata

    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def human_bytes(size: float) -> str:
    """A size as rosbag writes it: "1.5 MB"."""
    for suffix in ("KB", "MB", "GB", "TB", "PB"):
        size /= 1024.0
        if size < 1024.0:
            return f"{size:.1f} {suffix}"
    return "-"


def near_names(word: str, names: Iterable[str], *, cutoff: float = 0.6) -> list[str]:
    """Return up to three names that resemble a word, the best first; upper and lower case are equal.

    Args:
        word: As it was given.
        names: Those that exist.
        cutoff: The least similarity, 0 to 1; lower for short names.
    """
    from difflib import get_close_matches  # needed for an error only

    by_lower: dict[str, str] = {}
    for name in names:
        by_lower.setdefault(name.lower(), name)
    return [by_lower[match] for match in get_close_matches(word.lower(), by_lower, 3, cutoff)]
