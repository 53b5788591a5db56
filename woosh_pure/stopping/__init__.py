"""Stopping what this client and others have started, from any thread, and at the end of the process."""

from __future__ import annotations

from woosh_pure.stopping.active_motions import ActiveMotions
from woosh_pure.stopping.report import StopReport

__all__ = ["ActiveMotions", "StopReport"]
