"""Where a program made a subscriber, a service or an action server: has that call returned?

Messages may come before the constructor has returned: a latched one comes at once, and between two nodes of
one process nothing takes any time. Programs do not expect their callback to run before
`self.scan = node.subscriber(...)` has assigned anything. So the first call of a callback waits until the
program has gone on behind that call; no later one asks.

The frame itself is not kept, as it would keep everything alive that the caller had: where it stood is enough.
"""

from __future__ import annotations

import sys
import threading
import time
from types import FrameType

from rosproto.codec import pause

__all__ = ["CallSite"]

PATIENCE = 0.25  # seconds; a loop may come back to the same place again and again
LOOK_EVERY = 0.0005


class CallSite:
    """One call in one thread.

    Args:
        frame: The caller's: `sys._getframe(1)` in a constructor.
    """

    __slots__ = ("_code", "_depth", "_done", "_place", "_thread")

    def __init__(self, frame: FrameType) -> None:
        self._done = False
        self._thread = threading.get_ident()
        self._code = frame.f_code
        self._place = frame.f_lasti
        self._depth = _depth(frame)

    @property
    def is_here(self) -> bool:
        """True in the thread of that call, while it has not returned: waiting would be in vain."""
        return threading.get_ident() == self._thread and not self.is_left

    @property
    def is_left(self) -> bool:
        """True when the program has gone on behind the call."""
        frame = _frame_of(self._thread)
        if frame is None:
            return True
        caller: FrameType | None = frame
        for _ in range(_depth(frame) - self._depth):
            caller = None if caller is None else caller.f_back
        if caller is None or caller.f_code is not self._code:
            return True
        return caller.f_lasti != self._place or _depth(caller) != self._depth

    def wait(self) -> None:
        """Return when the program has gone on; after `PATIENCE` in any case, at once in its own thread."""
        if self._done or threading.get_ident() == self._thread:
            return
        end = time.monotonic() + PATIENCE
        while not self.is_left and time.monotonic() < end:
            time.sleep(LOOK_EVERY)
        self._done = True


def _frame_of(thread: int) -> FrameType | None:
    """What that thread runs now; None when it has ended.

    The collector is kept away meanwhile: before 3.11.9 the interpreter holds its list of threads while it
    makes the frame objects. Should that begin a collection, and this end a `threading.local`, the same thread
    waits for the list that it holds itself, and has the interpreter's lock: the process stands still, and
    every time-out in it (github.com/python/cpython/issues/106883).
    """
    pause.pause()
    try:
        return sys._current_frames().get(thread)
    finally:
        pause.resume()


def _depth(frame: FrameType | None) -> int:
    count = 0
    while frame is not None:
        count += 1
        frame = frame.f_back
    return count
