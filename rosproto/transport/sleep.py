"""Notices that this computer was asleep: a laptop whose lid was closed.

Linux and macOS stop the monotonic clock meanwhile, so no wait is over early when the computer wakes; Windows
not, so a wait takes far longer than it was meant to. Both are seen here.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

NOTICEABLE = 5.0
"""Seconds; less is a busy computer, or a clock that was set."""


def _time_with_sleep() -> float:
    """Seconds that pass in sleep too: exact on Linux, elsewhere the wall clock, which may be set."""
    if sys.platform == "linux":
        return time.clock_gettime(time.CLOCK_BOOTTIME)
    return time.time()


class SleepDetector:
    """Compares two clocks each time it is asked.

    Args:
        monotonic: Seconds awake.
        with_sleep: Seconds awake and asleep.
    """

    def __init__(
        self,
        monotonic: Callable[[], float] = time.monotonic,
        with_sleep: Callable[[], float] = _time_with_sleep,
    ) -> None:
        self._monotonic = monotonic
        self._with_sleep = with_sleep
        self._last = monotonic(), with_sleep()

    def slept(self, meant: float) -> float:
        """Seconds asleep since this was asked last; 0 when it is not noticeable.

        Args:
            meant: Seconds that were to pass at most until now.
        """
        now = self._monotonic(), self._with_sleep()
        awake, whole = (a - b for a, b in zip(now, self._last, strict=True))
        self._last = now
        missing = max(whole - awake, awake - meant)
        return missing if missing >= NOTICEABLE else 0.0
