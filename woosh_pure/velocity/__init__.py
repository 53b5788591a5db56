"""Driving by velocity: the block, its limits, and what is watched while it is open."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.late import late_names

if TYPE_CHECKING:
    from woosh_pure.velocity.drive import Drive
    from woosh_pure.velocity.shaper import DriveLimits

__all__ = ["Drive", "DriveLimits"]

__getattr__ = late_names(__name__, {"Drive": "drive", "DriveLimits": "shaper"})
