"""Wait for a moment with an error of tens of microseconds, without keeping a processor busy.

Operating systems wake a sleeping thread late: by 60 us on Linux, by up to 15 ms on an old Windows. So the
pacer sleeps until shortly before the moment and spins for the rest. How long it spins depends on how late it
was woken before.
"""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["Pacer"]

LEAST_SPIN = 0.0001
MOST_SPIN = 0.003  # seconds; spinning cannot make up for wake-ups later than this


class Pacer:
    """Waits for moments of a monotonic clock.

    Args:
        now: The clock, seconds.
        sleep: Sleeps for that many seconds, perhaps longer.

    Attributes:
        spin: How many seconds before the moment sleeping ends.
    """

    def __init__(
        self, now: Callable[[], float] = time.perf_counter, sleep: Callable[[float], object] = time.sleep
    ) -> None:
        self.now = now
        self._sleep = sleep
        self.spin = 0.0003

    def wait_until(self, moment: float) -> None:
        """Return at that moment, or immediately if it has passed."""
        left = moment - self.now()
        if left > self.spin:
            self._rest(left - self.spin)
        while self.now() < moment:
            self._sleep(0)  # yields the interpreter to the sending threads

    def rest(self, seconds: float) -> None:
        """Sleep for about that long."""
        self._sleep(seconds)

    def _rest(self, seconds: float) -> None:
        before = self.now()
        self._sleep(seconds)
        late = self.now() - before - seconds
        # Quickly up, slowly down: a late wake-up misses a moment, while more spinning costs little.
        wanted = min(max(1.5 * late, LEAST_SPIN), MOST_SPIN)
        self.spin = wanted if wanted > self.spin else self.spin + 0.02 * (wanted - self.spin)
