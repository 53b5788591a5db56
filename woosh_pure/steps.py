"""The name that programs import: all of it is in `woosh_pure.motion.steps`."""

from __future__ import annotations

from woosh_pure.motion.steps import MAX_ANGLE, MAX_DISTANCE, Step, check_steps, locate_step

__all__ = ["MAX_ANGLE", "MAX_DISTANCE", "Step", "check_steps", "locate_step"]
