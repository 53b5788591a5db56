"""What the keys of `woosh drive` mean. Pure.

Terminals send no key-up: a held key is a stream of repeats, and its end is silence. So each key is a velocity
that lapses by itself, and every key that is not one of the four directions stops.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["VALID_FOR", "Command", "Teleop"]

VALID_FOR = 0.3
"""Seconds a key is good for. The velocity is sent at 20 Hz, so zero is out within 0.4 s of the last key."""

_DIRECTIONS = {
    "up": (1.0, 0.0),
    "w": (1.0, 0.0),
    "down": (-1.0, 0.0),
    "s": (-1.0, 0.0),
    "left": (0.0, 1.0),
    "a": (0.0, 1.0),
    "right": (0.0, -1.0),
    "d": (0.0, -1.0),
}
_QUIT = ("q", "escape", "end")
_STEPS = (0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True, slots=True)
class Command:
    """What to do now: vx in m/s, wz in rad/s."""

    vx: float = 0.0
    wz: float = 0.0
    quit: bool = False

    @property
    def moves(self) -> bool:
        """True when it is not a stop."""
        return bool(self.vx or self.wz)


class Teleop:
    """Turns keys into commands.

    Args:
        linear, angular: Full speed, m/s and rad/s.
    """

    def __init__(self, linear: float, angular: float) -> None:
        self._linear, self._angular = linear, angular
        self._step = 1

    @property
    def speed(self) -> float:
        """Part of the full speed, 0.25 to 1; begins with half of it."""
        return _STEPS[self._step]

    def press(self, keys: Sequence[str]) -> Command | None:
        """What keys that came together mean; None when there were none.

        When one of them is not a direction it wins, in whatever order they came: a stop is never overtaken.
        """
        if not keys:
            return None
        if any(key in _QUIT for key in keys):
            return Command(quit=True)
        for key in keys:
            if key in ("+", "=", "-"):
                self._step = min(max(self._step + (-1 if key == "-" else 1), 0), len(_STEPS) - 1)
        if any(key not in _DIRECTIONS for key in keys):
            return Command()
        forward, left = _DIRECTIONS[keys[-1]]
        return Command(forward * self._linear * self.speed, left * self._angular * self.speed)
