"""The load of this computer, for time limits that assume a quiet one."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["crowd", "waited_for_the_processor"]

SCHEDULER = Path("/proc/thread-self/schedstat")  # ns on the processor, ns ready without one, slices


def crowd() -> float:
    """Return the number of runnable processes per processor: the slow-down compared with a quiet computer."""
    try:
        return max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))
    except (AttributeError, OSError):  # Windows has no such figure
        return 1.0


def waited_for_the_processor() -> float:
    """Seconds in which this thread was ready to run and did not, since it began; 0.0 where nobody counts them."""
    try:
        return int(SCHEDULER.read_text().split()[1]) / 1e9
    except (OSError, IndexError):
        return 0.0
