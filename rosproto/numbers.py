"""Numbers that callers give, as Python's own float or int from there on.

What numpy, Decimal or Fraction give is a number to people, and fails much later: a lock takes no np.float32
as its time-out, and `time.monotonic() + np.float16(0.5)` has steps of 64 seconds or is infinite.
"""

from __future__ import annotations

import operator
from typing import SupportsFloat, overload

__all__ = ["as_float", "whole"]


@overload
def as_float(value: SupportsFloat) -> float: ...


@overload
def as_float(value: SupportsFloat | None) -> float | None: ...


def as_float(value: SupportsFloat | None) -> float | None:
    """A number as a float; None stays None, where that means "for ever".

    Raises:
        TypeError: It is not a number; a text does not count as one.
    """
    if value is None or type(value) is float:
        return value
    if isinstance(value, (str, bytes, bytearray)):
        raise TypeError(f"{value!r} is a text; expected a number")
    return float(value)


def whole(value: object) -> int | None:
    """A whole number as an int, numpy's too; None when it is none (also 1.0: that is a measured number)."""
    try:
        return operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return None
