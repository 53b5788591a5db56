"""The name that programs import: all of it is in `woosh_pure.motion.action_goal`."""

from __future__ import annotations

from woosh_pure.motion.action_goal import (
    ActionHandle,
    NavigationHandle,
    NavigationProgress,
    StepHandle,
    StepProgress,
)

__all__ = ["ActionHandle", "NavigationHandle", "NavigationProgress", "StepHandle", "StepProgress"]
