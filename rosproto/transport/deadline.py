"""One moment by which all steps of an operation must be done."""

from __future__ import annotations

from rosproto.errors import RosTimeout
from rosproto.numbers import as_float
from rosproto.sentence import led, say
from rosproto.transport.clock import SYSTEM, Clock


class Deadline:
    """A moment on the monotonic clock, `timeout` seconds from now; None never comes.

    Made once at the start of a call and handed down, so that several steps share one budget.

    Attributes:
        seconds: The whole budget, as given.
    """

    __slots__ = ("_at", "_clock", "seconds")

    def __init__(self, timeout: float | None, clock: Clock = SYSTEM) -> None:
        self.seconds = timeout = as_float(timeout)
        self._clock = clock
        self._at = None if timeout is None else clock.monotonic() + timeout

    def __repr__(self) -> str:
        left = self.remaining()
        return "Deadline(None)" if left is None else f"Deadline({self.seconds} s, {left:.3f} s left)"

    def remaining(self) -> float | None:
        """Seconds left, neither below 0 nor, by rounding, above `seconds`; None when there is no limit."""
        if self._at is None or self.seconds is None:
            return None
        return max(0.0, min(self.seconds, self._at - self._clock.monotonic()))

    def for_socket(self) -> float | None:
        """What `settimeout` takes: `remaining()`, but never 0, which would make the socket non-blocking.

        Raises:
            TimeoutError: No time is left.
        """
        left = self.remaining()
        if left is not None and left <= 0:
            raise TimeoutError
        return left

    @property
    def expired(self) -> bool:
        """No time is left."""
        return self._at is not None and self._clock.monotonic() >= self._at

    def check(self, what: str) -> None:
        """Raise when no time is left.

        Raises:
            RosTimeout: `what` is what was waited for.
        """
        if self.expired:
            raise self.error(what)

    def error(self, what: str) -> RosTimeout:
        """The error for `what` not being done in time, to be raised by the caller."""
        return RosTimeout(
            led(what, say("not within {seconds} s", seconds=self.seconds)), what=what, seconds=self.seconds
        )

    def at_most(self, seconds: float) -> Deadline:
        """The earlier of this deadline and `seconds` from now."""
        left, seconds = self.remaining(), as_float(seconds)
        return Deadline(seconds if left is None else min(seconds, left), self._clock)
