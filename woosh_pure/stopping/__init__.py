"""Stopping what this client and others have started, from any thread, and at the end of the process."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.late import late_names

if TYPE_CHECKING:
    from woosh_pure.stopping.report import StopReport
    from woosh_pure.stopping.running import Running

__all__ = ["Running", "StopReport"]

__getattr__ = late_names(__name__, {"Running": "running", "StopReport": "report"})
