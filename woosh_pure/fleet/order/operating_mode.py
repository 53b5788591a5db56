"""Operating modes (6.10.6). Pure."""

from __future__ import annotations

__all__ = ["DRIVING_MODES", "operating_mode"]

DRIVING_MODES = ("AUTOMATIC", "SEMIAUTOMATIC")
"""Those in which the fleet manager is in control."""


def operating_mode(robot_mode: int, *, owner: str = "") -> str:
    """The operating mode of a robot_mode: 2 is manual, 3 maintenance; a local driver who has the robot
    makes it MANUAL, whatever its key says."""
    if robot_mode == 3:
        return "SERVICE"
    return "MANUAL" if robot_mode == 2 or owner else "AUTOMATIC"
