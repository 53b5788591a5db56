"""Checking what callers give as a time limit. Pure."""

from __future__ import annotations

import math

from rosproto.numbers import as_float
from rosproto.sentence import say

__all__ = ["LONGEST", "require_limit", "require_timeout"]

LONGEST = 864_000.0
"""Seconds."""


def require_timeout(timeout: float | None, name: str = "timeout") -> float | None:
    """A time limit, checked, as a float: seconds of at least 0, or None for no limit.

    Raises:
        ValueError: It is negative or NaN. (A NaN would never be over, a negative one over at once.)
    """
    seconds = as_float(timeout)
    if seconds is None or (seconds >= 0.0 and not math.isnan(seconds)):
        return seconds
    raise ValueError(
        say(
            "{name}={timeout}: expected seconds of at least 0, or None to wait for ever",
            name=name,
            timeout=timeout,
        )
    )


def require_limit(timeout: float, name: str = "timeout") -> float:
    """As `require_timeout`, where there is always a limit: at most 10 days, since the system's own waits take
    no number as large as a float can be.

    Raises:
        ValueError: It is negative, NaN or infinite.
    """
    seconds = as_float(timeout)
    if seconds is None or not 0.0 <= seconds < math.inf:
        raise ValueError(
            say(
                "{name}={timeout}: expected seconds of at least 0, and not for ever",
                name=name,
                timeout=timeout,
            )
        )
    return min(seconds, LONGEST)
