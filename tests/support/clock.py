"""A clock that only the test moves."""

from __future__ import annotations

import threading


class FakeClock:
    """Fits `rosproto.transport.deadline.Clock`; `wait` returns at once, moving the time by its time-out.

    A waitable that is already signalled does not move the time.
    """

    def __init__(self, now: float = 1000.0) -> None:
        self._lock = threading.Lock()
        self.now = now
        self.waits: list[float | None] = []

    def monotonic(self) -> float:
        with self._lock:
            return self.now

    def advance(self, seconds: float) -> None:
        with self._lock:
            self.now += seconds

    def wait(self, waitable, timeout):  # type: ignore[no-untyped-def]
        self.waits.append(timeout)
        if waitable.wait(0):
            return True
        if timeout is not None:
            self.advance(timeout)
        return False
