"""An event that can be set over any frame: `set` takes no lock that somebody could hold.

`threading.Event.set` takes the lock of its condition. A signal handler's stop works in another thread while
the interrupted frame, perhaps in the middle of `Event.wait`, holds that lock until the handler returns. Here
a waiter waits in a `SimpleQueue`, whose methods are C: they are done or not begun when a handler runs.
"""

from __future__ import annotations

import queue
import time

__all__ = ["SLICE", "Flag"]

SLICE = 0.1
"""Seconds: on Windows a lock that waits cannot be interrupted, so waits are cut into slices."""


class Flag:
    """Set once, for good. Safe from any thread and any signal handler.

    Attributes:
        is_set: Whether it is.
    """

    __slots__ = ("_woken", "is_set")

    def __init__(self) -> None:
        self.is_set = False
        self._woken: queue.SimpleQueue[None] = queue.SimpleQueue()

    def set(self) -> None:
        """Set it, and wake who waits."""
        self.is_set = True
        self._woken.put(None)

    def wait(self, timeout: float) -> bool:
        """Wait until it is set, for so many seconds at most; whether it is."""
        end = time.monotonic() + timeout
        while not self.is_set and (left := end - time.monotonic()) > 0.0:
            try:
                self._woken.get(timeout=min(left, SLICE))
            except queue.Empty:
                continue
            self._woken.put(None)  # the next one's
        return self.is_set
