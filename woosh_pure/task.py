"""The name that programs import: all of it is in `woosh_pure.motion.task`."""

from __future__ import annotations

from woosh_pure.motion.task import TaskHandle

__all__ = ["TaskHandle"]
