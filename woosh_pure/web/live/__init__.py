"""The live connection of the page: what it shows, and driving with a dead-man switch."""

from __future__ import annotations

from woosh_pure.web.live.deadman import DeadMan, Verdict

__all__ = ["DeadMan", "Verdict"]
