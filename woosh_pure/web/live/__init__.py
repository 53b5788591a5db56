"""The live connection of the page: what is shown, and the dead man's hand on the robot."""

from __future__ import annotations

from woosh_pure.web.live.deadman import DeadMan, Verdict

__all__ = ["DeadMan", "Verdict"]
