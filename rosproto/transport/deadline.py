"""Deadlines, a replaceable clock, waits that Ctrl-C can end, and detection of a computer's sleep.

On Windows a thread that waits for a lock does not notice Ctrl-C until the wait is over, so `for message in
subscriber` could not be stopped while no message came. There, long waits are cut into slices.

While the computer sleeps (a laptop with its lid closed), Linux and macOS stop the monotonic clock, so no wait
ends early after waking. Windows does not, so a wait takes much longer than intended. `SleepDetector` detects
both.
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Callable
from typing import Protocol, TypeVar

from rosproto.coercion import as_float
from rosproto.errors import RosTimeout
from rosproto.sentence import led, say

T = TypeVar("T")


def next_item(items: queue.SimpleQueue[T], seconds: float | None) -> T:
    """Wait for the next item, in a thread that nobody shares the queue with.

    `items.get(timeout=seconds)` alone may wait for ever before CPython 3.13: if its lock is open, it takes
    the lock without waiting, and a time that has run out meanwhile counts as no limit. The first look here
    closes the lock.

    Raises:
        queue.Empty: None came within `seconds`.
    """
    try:
        return items.get_nowait()
    except queue.Empty:
        return items.get(timeout=seconds)


class Waitable(Protocol):
    """A `threading.Event` or a `threading.Condition` (held by the caller)."""

    def wait(self, timeout: float | None = None) -> bool:
        """True if signalled, False if `timeout` seconds passed."""


class MonotonicClock(Protocol):
    """A clock that never jumps, such as the module `time`."""

    def monotonic(self) -> float:
        """Seconds since an arbitrary fixed moment."""


class Clock(MonotonicClock, Protocol):
    """A clock, and waiting by it."""

    def wait(self, waitable: Waitable, timeout: float | None) -> bool:
        """Wait until signalled, at most `timeout` seconds; True if signalled."""


class SystemClock:
    """The computer's monotonic clock."""

    def monotonic(self) -> float:
        """`time.monotonic()`, seconds."""
        return time.monotonic()

    def wait(self, waitable: Waitable, timeout: float | None) -> bool:
        """`waitable.wait(timeout)`."""
        return waitable.wait(timeout)


SYSTEM = SystemClock()


class Deadline:
    """A moment on the monotonic clock, `timeout` seconds from now; None never comes.

    Create it once at the start of a call and pass it on, so that all steps share one budget.

    Attributes:
        seconds: The whole budget, as given.
    """

    __slots__ = ("_at", "_clock", "seconds")

    def __init__(self, timeout: float | None, clock: MonotonicClock = time) -> None:
        self.seconds = timeout = as_float(timeout)
        self._clock = clock
        self._at = None if timeout is None else clock.monotonic() + timeout

    def __repr__(self) -> str:
        left = self.remaining()
        return "Deadline(None)" if left is None else f"Deadline({self.seconds} s, {left:.3f} s left)"

    def remaining(self) -> float | None:
        """Seconds left, from 0 to `seconds`; None if there is no limit."""
        if self._at is None or self.seconds is None:
            return None
        return max(0.0, min(self.seconds, self._at - self._clock.monotonic()))

    def for_socket(self) -> float | None:
        """The value for `settimeout`: `remaining()`, but never 0, which would make the socket non-blocking.

        Raises:
            TimeoutError: No time is left.
        """
        left = self.remaining()
        if left is not None and left <= 0:
            raise TimeoutError
        return left

    @property
    def expired(self) -> bool:
        """Whether no time is left."""
        return self._at is not None and self._clock.monotonic() >= self._at

    def check(self, what: str) -> None:
        """Raise if no time is left.

        Raises:
            RosTimeout: `what` did not happen in time.
        """
        if self.expired:
            raise self.error(what)

    def error(self, what: str) -> RosTimeout:
        """The error to raise when `what` was not done in time."""
        return RosTimeout(
            led(what, say("not within {seconds} s", seconds=self.seconds)), what=what, seconds=self.seconds
        )

    def at_most(self, seconds: float) -> Deadline:
        """The earlier of this deadline and `seconds` from now."""
        left = self.remaining()
        return Deadline(seconds if left is None else min(seconds, left), self._clock)


SLICE = 0.25 if sys.platform == "win32" else None
"""Longest time until Ctrl-C is noticed, seconds; None: at once."""


def wait_for(condition: threading.Condition, predicate: Callable[[], object], timeout: float | None) -> bool:
    """`condition.wait_for(predicate, timeout)` with the lock held; True if the predicate became true."""
    return _in_slices(lambda seconds: bool(condition.wait_for(predicate, seconds)), timeout)


def wait_event(event: threading.Event, timeout: float | None) -> bool:
    """`event.wait(timeout)`; True if it is set."""
    return _in_slices(event.wait, timeout)


def _in_slices(wait: Callable[[float | None], bool], timeout: float | None) -> bool:
    timeout = as_float(timeout)
    if SLICE is None:
        return wait(timeout)
    end = None if timeout is None else time.monotonic() + timeout
    while True:
        left = SLICE if end is None else end - time.monotonic()
        if wait(max(0.0, min(SLICE, left))):
            return True
        if left <= SLICE and end is not None:
            return False


NOTICEABLE = 5.0
"""Seconds; a shorter gap may be a busy computer or an adjusted clock."""


def _time_with_sleep() -> float:
    """Seconds including sleep: exact on Linux; elsewhere the wall clock, which may be set."""
    if sys.platform == "linux":
        return time.clock_gettime(time.CLOCK_BOOTTIME)
    return time.time()


class SleepDetector:
    """Compares two clocks on each call.

    Args:
        monotonic: Seconds without sleep.
        with_sleep: Seconds including sleep.
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
        """Seconds asleep since the last call; 0 if too short to tell.

        Args:
            meant: Longest time that was planned to pass since the last call, seconds.
        """
        now = self._monotonic(), self._with_sleep()
        awake, whole = (a - b for a, b in zip(now, self._last, strict=True))
        self._last = now
        missing = max(whole - awake, awake - meant)
        return missing if missing >= NOTICEABLE else 0.0
