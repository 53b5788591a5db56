"""How many columns of a terminal a text takes: Chinese characters take two each."""

from __future__ import annotations

__all__ = ["cut", "padded", "width"]


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
