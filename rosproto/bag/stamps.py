"""The times that callers pass to bags: Time, or seconds since 1970."""

from __future__ import annotations

from math import isfinite
from numbers import Real
from typing import Any

from rosproto.bag.records import NS
from rosproto.time import Time

Stamp = Time | float


def seconds_and_rest(stamp: Any) -> tuple[int, int]:
    """Seconds and nanoseconds of any number (numpy's too), or of an object with secs and nsecs.

    Raises:
        ValueError: It is not a time, or not finite.
    """
    if isinstance(stamp, Real):
        if not isfinite(stamp):
            raise out_of_range(float(stamp))
        return divmod(round((stamp if isinstance(stamp, int) else float(stamp)) * NS), NS)
    try:
        return stamp.secs, stamp.nsecs
    except AttributeError:
        raise ValueError(
            f"time {stamp!r}: Time, or seconds since 1970, is expected, not {type(stamp).__name__}"
        ) from None


def to_ns(stamp: Stamp) -> int:
    """Nanoseconds since 1970.

    Raises:
        ValueError: See `seconds_and_rest`.
    """
    secs, nsecs = seconds_and_rest(stamp)
    return int(secs) * NS + int(nsecs)


def out_of_range(stamp: Stamp) -> ValueError:
    """The error of a time that no bag can store."""
    hint = "; give seconds, not nanoseconds" if isinstance(stamp, (int, float)) and stamp > 1e12 else ""
    return ValueError(
        f"time {stamp!r}: a bag stores unsigned 32-bit seconds and nanoseconds since 1970{hint}"
    )
