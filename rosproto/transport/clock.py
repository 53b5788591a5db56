"""The monotonic clock that every wait here goes by, as a seam: tests put their own in."""

from __future__ import annotations

import time
from typing import Protocol


class Waitable(Protocol):
    """A `threading.Event` or a `threading.Condition` (held by the caller)."""

    def wait(self, timeout: float | None = None) -> bool:
        """True when signalled, False when `timeout` seconds passed."""


class Clock(Protocol):
    """Time that never jumps, and waiting by it."""

    def monotonic(self) -> float:
        """Seconds since some fixed moment."""

    def wait(self, waitable: Waitable, timeout: float | None) -> bool:
        """Wait until signalled, at most `timeout` seconds; True when signalled."""


class SystemClock:
    """The computer's own monotonic clock."""

    def monotonic(self) -> float:
        """`time.monotonic()`, seconds."""
        return time.monotonic()

    def wait(self, waitable: Waitable, timeout: float | None) -> bool:
        """`waitable.wait(timeout)`."""
        return waitable.wait(timeout)


SYSTEM = SystemClock()
