"""A clock that counts the time in which this computer slept.

`time.monotonic()` stands still on Linux and macOS while a laptop is closed, so that a command given before
would seem fresh afterwards. Wall time does count it, but people and NTP set it.
"""

from __future__ import annotations

import time

__all__ = ["seconds"]


def _source() -> int | None:
    # Linux: CLOCK_BOOTTIME. macOS and the BSDs: CLOCK_MONOTONIC, unlike what time.monotonic() takes there.
    # Windows has neither; its time.monotonic() goes on in sleep.
    found: int | None = getattr(time, "CLOCK_BOOTTIME", getattr(time, "CLOCK_MONOTONIC", None))
    return found


_SOURCE = _source()


def seconds() -> float:
    """Seconds since an arbitrary moment; never set, and going on while the computer sleeps."""
    if _SOURCE is None or not hasattr(time, "clock_gettime"):
        return time.monotonic()
    now: float = time.clock_gettime(_SOURCE)
    return now
