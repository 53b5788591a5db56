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
    """The level of this name, the original's short spellings included; None for an unknown one."""
    return _SPELLINGS.get(name)


def is_wanted(level: Level, asked: Level) -> bool:
    """Whether a status of `level` goes to a client that asked for `asked`."""
    return 0 < LEVELS.index(level) <= LEVELS.index(asked)
