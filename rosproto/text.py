"""Text that others wrote, made fit for a terminal and a log: nothing in it acts, hides or begins a line.

A peer's text (a name, an error, a type, a frame) may hold what a terminal obeys: escape sequences that move
the cursor, rename the window or answer as if typed; a line feed that forges a line of ours; characters that
turn the direction of writing or that nobody sees. Unicode has a property for all of these: they are not
printable. So nothing is listed here that could be forgotten.

Everything that is not printable becomes an escape as Python and YAML write it (`\\x1b`, `\\u202e`, `\\n`).
Letters of any language stay as they are, and so does every kind of blank (Chinese has one of its own).

And how many columns of a terminal a text takes: Chinese characters take two each.
"""

from __future__ import annotations

__all__ = ["cut", "human_bytes", "padded", "printable", "width"]

_BLANKS = frozenset(
    "\xa0\u1680\u2000\u2001\u2002\u2003\u2004\u2005\u2006\u2007\u2008\u2009\u200a\u202f\u205f\u3000"
)
"""Category Zs: blanks that `str.isprintable` does not count, as only the ASCII one is."""
_SHORT = {"\n": "\\n", "\r": "\\r", "\t": "\\t"}


def printable(text: str, *, keep: str = "") -> str:
    """The text with everything escaped that a terminal would obey or not show.

    Args:
        text: From a peer, a bag, a file.
        keep: Characters that stay all the same: `"\\n"` where lines are meant, `"\\n\\t"` for tables.

    Returns:
        The text itself when there is nothing to escape.
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


def width(text: str) -> int:
    """Columns that it takes; combining characters take none."""
    return len(text) if text.isascii() else sum(map(_columns, text))


def padded(text: str, columns: int) -> str:
    """Followed by blanks up to so many columns, as `str.ljust` counts characters."""
    return text + " " * max(0, columns - width(text))


def cut(text: str, columns: int) -> str:
    """What of it fits into so many columns; no character is halved."""
    if text.isascii():
        return text[: max(0, columns)]
    taken = 0
    for index, character in enumerate(text):
        taken += _columns(character)
        if taken > columns:
            return text[:index]
    return text


def _columns(character: str) -> int:
    import unicodedata

    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def human_bytes(size: float) -> str:
    """As rosbag writes sizes: "1.5 MB"."""
    for suffix in ("KB", "MB", "GB", "TB", "PB"):
        size /= 1024.0
        if size < 1024.0:
            return f"{size:.1f} {suffix}"
    return "-"
