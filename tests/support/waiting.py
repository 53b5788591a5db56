"""Wait for what happens in another thread or process, with a deadline."""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["until"]

PAUSE = 0.005  # seconds between two looks


def until(condition: Callable[[], object], timeout: float = 20.0, what: object = "it") -> None:
    """Return as soon as the condition is true.

    Args:
        condition: Called again and again, in this thread.
        timeout: Seconds; long, since only a failure takes them.
        what: What is waited for, for the text of a failure. If it is a function, its result then.

    Raises:
        AssertionError: It did not come true in time.
    """
    end = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"{what() if callable(what) else what} did not come true within {timeout} s")
        time.sleep(PAUSE)
