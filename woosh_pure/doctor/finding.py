"""What one check of `woosh doctor` found, as a value."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

__all__ = ["Finding", "Level"]


class Level(Enum):
    """How bad a finding is."""

    OK = "ok"
    WARNING = "warning"
    PROBLEM = "PROBLEM"


@dataclass(frozen=True, slots=True)
class Finding:
    """What one check found.

    Attributes:
        check: Its name, for programs.
        level: How bad it is.
        text: What was found.
        advice: What to do; "" when nothing is needed.
    """

    check: str
    level: Level
    text: str
    advice: str = ""
