"""rosbridge's status messages: which are sent at which level (ROSBRIDGE_PROTOCOL.md, 3.2)."""

from __future__ import annotations

from typing import Literal

Level = Literal["none", "error", "warning", "info"]

LEVELS: tuple[Level, ...] = ("none", "error", "warning", "info")
"""Each level includes those before it."""

_SPELLINGS: dict[str, Level] = {
    "none": "none",
    "error": "error",
    "err": "error",
    "warning": "warning",
    "warn": "warning",
    "info": "info",
    "information": "info",
}


def level_named(name: str) -> Level | None:
    """The level with this name or a short spelling of the original; None if unknown."""
    return _SPELLINGS.get(name)


def is_wanted(level: Level, asked: Level) -> bool:
    """Whether a client that chose the level `asked` gets a status of `level`."""
    return 0 < LEVELS.index(level) <= LEVELS.index(asked)
