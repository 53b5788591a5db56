"""Waiting for a moment to within tens of microseconds, without burning a processor for it.

The operating system wakes a sleeper late: 60 us on Linux, up to 15 ms on an old Windows. So the pacer sleeps
until shortly before the moment and spins for the rest; how shortly follows from how late it has been woken.
"""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["Pacer"]

LEAST_SPIN = 0.0001
MOST_SPIN = 0.003  # seconds; a system that wakes later than this is not made precise by spinning


class Pacer:
    """Waits for moments of a monotonic clock.

    Args:
        now: The clock, seconds.
        sleep: Sleeps that many seconds, perhaps longer.

    Attributes:
        spin: Seconds before the moment at which sleeping ends.
    """

    def __init__(
        self, now: Callable[[], float] = time.perf_counter, sleep: Callable[[float], object] = time.sleep
    ) -> None:
        self.now = now
        self._sleep = sleep
        self.spin = 0.0003

    def wait_until(self, moment: float) -> None:
        """Return at that moment, or at once if it has passed."""
        left = moment - self.now()
        if left > self.spin:
            self._rest(left - self.spin)
        while self.now() < moment:
            self._sleep(0)  # lets the threads that send have the interpreter

    def rest(self, seconds: float) -> None:
        """Sleep about that long."""
        self._sleep(seconds)

    def _rest(self, seconds: float) -> None:
        before = self.now()
        self._sleep(seconds)
        late = self.now() - before - seconds
        # Quickly up, slowly down: one late wake-up spoils a moment, a little spinning costs little.
        wanted = min(max(1.5 * late, LEAST_SPIN), MOST_SPIN)
        self.spin = wanted if wanted > self.spin else self.spin + 0.02 * (wanted - self.spin)
