"""Stopping what this client and others have started, from any thread, and at the end of the process."""

from __future__ import annotations

from woosh_pure.stopping.report import StopReport
from woosh_pure.stopping.running import Running

__all__ = ["Running", "StopReport"]
