"""Text that others wrote, made fit for a terminal and a log: nothing in it acts, hides or begins a line.

A peer's text (a name, an error, a type, a frame) may hold what a terminal obeys: escape sequences that move
the cursor, rename the window or answer as if typed; a line feed that forges a line of ours; characters that
turn the direction of writing or that nobody sees. Unicode has a property for all of these: they are not
printable. So nothing is listed here that could be forgotten.

Everything that is not printable becomes an escape as Python and YAML write it (`\\x1b`, `\\u202e`, `\\n`).
Letters of any language stay as they are, and so does every kind of blank (Chinese has one of its own).
"""

from __future__ import annotations

__all__ = ["printable"]

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
