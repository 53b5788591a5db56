"""Checking what callers give as a time limit. Pure."""

from __future__ import annotations

import math

__all__ = ["require_timeout"]


def require_timeout(timeout: float | None, name: str = "timeout") -> float | None:
    """A time limit, checked: seconds of at least 0, or None for no limit.

    Raises:
        ValueError: It is negative or NaN. (A NaN would never be over, a negative one over at once.)
    """
    if timeout is None or (timeout >= 0.0 and not math.isnan(timeout)):
        return timeout
    raise ValueError(f"{name}={timeout}: expected seconds of at least 0, or None to wait for ever")
