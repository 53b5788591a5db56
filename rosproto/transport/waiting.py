"""Waits that Ctrl-C can end.

On Windows a thread that waits for a lock, with or without a time-out, does not notice Ctrl-C until the wait
is over: `for message in subscriber` could not be stopped while nothing came. There long waits are cut into
slices; elsewhere they are what they were.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable

from rosproto.numbers import as_float

SLICE = 0.25 if sys.platform == "win32" else None
"""Seconds until Ctrl-C is noticed; None: at once."""


def wait_for(condition: threading.Condition, predicate: Callable[[], object], timeout: float | None) -> bool:
    """`condition.wait_for(predicate, timeout)`, the lock held; True when it came true."""
    return _in_slices(lambda seconds: bool(condition.wait_for(predicate, seconds)), timeout)


def wait_event(event: threading.Event, timeout: float | None) -> bool:
    """`event.wait(timeout)`; True when it is set."""
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
