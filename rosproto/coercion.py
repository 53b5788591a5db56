"""Convert numbers given by callers (numpy, Decimal, Fraction) to Python's float or int; check callbacks.

Unconverted they fail later: a lock does not accept np.float32 as its time-out, and `time.monotonic() +
np.float16(0.5)` has steps of 64 seconds or is infinite.
"""

from __future__ import annotations

import math
import operator
from typing import SupportsFloat, TypeVar, overload

from rosproto.sentence import say

__all__ = ["as_float", "require_callback", "require_number", "whole"]

T = TypeVar("T")


@overload
def as_float(value: SupportsFloat) -> float: ...


@overload
def as_float(value: SupportsFloat | None) -> float | None: ...


def as_float(value: SupportsFloat | None) -> float | None:
    """A number as a float; None stays None, where that means "for ever".

    A number beyond float becomes infinite (`10**400`) or NaN (`Decimal("sNaN")`); callers that need finite
    numbers refuse these with an error of their own.

    Raises:
        TypeError: It is not a number; neither a text nor a truth value counts as one.
    """
    if value is None or type(value) is float:
        return value
    if isinstance(value, (str, bytes, bytearray)):
        raise TypeError(say("{value!r} is a string; expected a number", value=value))
    if isinstance(value, bool) or getattr(getattr(value, "dtype", None), "kind", "") == "b":
        raise TypeError(say("{value!r} is a boolean; expected a number", value=value))
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf  # type: ignore[operator]
    except ValueError:  # only Decimal's signalling NaN
        return math.nan
    except TypeError:
        raise TypeError(say("{x} is not a number; expected one, such as 0.5", x=repr(value))) from None


def require_number(value: SupportsFloat | None, name: str) -> float:
    """As `as_float`, where None is not a number either; the error has the parameter's name."""
    if value is None:
        raise TypeError(say("{x} is not a number; expected one, such as 0.5", x=f"{name}=None"))
    return as_float(value)


def whole(value: object) -> int | None:
    """A whole number as an int (numpy's included); None for anything else, also for 1.0 and True."""
    if isinstance(value, bool):
        return None
    try:
        return operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return None


def require_callback(callback: T, what: str = "the callback") -> T:
    """The callback, checked at once: an error with each message would be far from its cause.

    Raises:
        TypeError: It is not callable.
    """
    if not callable(callback):
        text = "{what} must be a function, not {given}; give its name without ()"
        raise TypeError(say(text, what=say(what), given=f"{callback!r:.80}"))
    return callback
