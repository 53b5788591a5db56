"""Numbers of things in a sentence: "1 problem", "2 problems", "1 of 3 nodes"."""

from __future__ import annotations

__all__ = ["counted"]


def counted(number: int, thing: str, things: str | None = None) -> str:
    """The number and what it counts, in the singular or plural.

    Args:
        number: How many.
        thing: One of them: "message".
        things: Several of them, where an s does not do: "retries".
    """
    return f"{number} {thing if number == 1 else things or thing + 's'}"
