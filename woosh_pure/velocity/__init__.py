"""Driving by velocity: the block, its limits, and what is watched while it is open."""

from __future__ import annotations

from woosh_pure.velocity.drive import Drive
from woosh_pure.velocity.shaper import DriveLimits

__all__ = ["Drive", "DriveLimits"]
