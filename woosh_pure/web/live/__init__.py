"""The live connection of the page: what it shows, and driving with a dead-man switch."""

from __future__ import annotations

from woosh_pure.web.live.deadman import DeadManSwitch, Verdict

__all__ = ["DeadManSwitch", "Verdict"]
