"""The operations of a filter expression; each is checked against limits before it begins.

An untrusted text may contain `9**9**9`, `'a' * 10**12` or `round(1, -10**9)`. So operand types and the
size of the result are checked first, and each value read or made costs steps. An evaluation has a fixed
number of steps.

Arrays of numbers are numpy arrays. They combine only with numbers and one-dimensional arrays: numpy would
broadcast others to the product of their sizes.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

MAX_STEPS = 500_000
MAX_BITS = 4096
MAX_EXPONENT = 1024
MAX_LENGTH = 1_000_000
MAX_DIGITS = 400
MAX_NUMBER_TEXT = 1000
PER_STEP = 32  # characters, bytes or numbers of an array that count as one step

FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{f.__name__: f for f in (abs, all, any, bool, float, int, len, max, min, round, sorted, str, sum)},
    **{name: getattr(math, name) for name in (
        "acos asin atan atan2 ceil copysign cos degrees exp fabs floor fmod hypot "
        "isfinite isinf isnan log log10 log2 radians sin sqrt tan"
    ).split()},
}  # fmt: skip
STRING_METHODS = frozenset("startswith endswith lower upper strip split find count".split())
_COST_NOTHING = ("len", "bool")


class LimitExceeded(ValueError):
    """An operation exceeds the limits of an expression."""


class Bounds:
    """The remaining steps of one evaluation, and the operations that use them."""

    def __init__(self) -> None:
        self.left = MAX_STEPS

    def spend(self, steps: int) -> None:
        """Use `steps` steps.

        Raises:
            LimitExceeded: Fewer steps remain.
        """
        self.left -= steps
        if self.left < 0:
            raise LimitExceeded("takes too many steps for one message")

    def weigh(self, value: object) -> None:
        """Use the steps for reading a whole value; repeated elements of a list count each time."""
        if isinstance(value, (str, bytes, bytearray)):
            self.spend(1 + len(value) // PER_STEP)
        elif isinstance(value, (list, tuple)):
            self.spend(1)
            for item in value:
                self.weigh(item)
        elif _is_array(value):
            self.spend(1 + value.size // PER_STEP)  # type: ignore[attr-defined]
        elif hasattr(type(value), "_slot_types"):
            self.spend(1)
            for name in type(value).__slots__:  # type: ignore[attr-defined]
                self.weigh(getattr(value, name))
        else:
            self.spend(1)

    def kept(self, value: Any) -> Any:
        """Check the length of an integer result, use the steps for a new value, and return the value.

        Raises:
            LimitExceeded: The value is too long.
        """
        if isinstance(value, int) and value.bit_length() > MAX_BITS:
            raise LimitExceeded(f"integers have {MAX_BITS} bits at most")
        if isinstance(value, (str, bytes, list, tuple)):
            if len(value) > MAX_LENGTH and not isinstance(value, bytes):
                raise LimitExceeded(f"texts and lists have {MAX_LENGTH} elements at most")
            self.weigh(value)
        return value

    def element(self, value: Any) -> Any:
        """Return a value as a list element: an array becomes a list, which numpy does not broadcast."""
        if _is_array(value):
            self.spend(value.size)
            return value.tolist()
        return value

    # -- operations ------------------------------------------------------------------------------------------

    def binary(self, name: str, left: Any, right: Any) -> Any:
        """Compute `left name right`; `name` is that of Python's operator function."""
        self._check_operands(name, left, right)
        if name == "pow":
            _check_power(left, right)
        return self.kept(getattr(operator, name)(left, right))

    def _check_operands(self, name: str, left: Any, right: Any) -> None:
        if _is_array(left) or _is_array(right):
            self._check_arrays(left, right)
        elif _is_sequence(left) or _is_sequence(right):
            self._check_sequences(name, left, right)
        elif not (_is_number(left) or hasattr(left, "to_nsec")) or not (
            _is_number(right) or hasattr(right, "to_nsec")
        ):
            raise LimitExceeded(f"{name} is not known for {_kind(left)} and {_kind(right)}")
        elif hasattr(left, "dtype") or hasattr(right, "dtype"):
            _check_fixed_width(left, right)

    def _check_arrays(self, left: Any, right: Any) -> None:
        for value in (left, right):
            if not (_is_number(value) or (_is_array(value) and value.ndim == 1 and value.dtype.kind != "O")):
                raise LimitExceeded(
                    f"an array is combined with a number or an array, not with {_kind(value)}"
                )
            self.weigh(value)
        _check_fixed_width(left, right)

    def _check_sequences(self, name: str, left: Any, right: Any) -> None:
        if name == "add" and _is_sequence(left) and _is_sequence(right):
            length = len(left) + len(right)
        elif name == "mul" and isinstance(left, int) != isinstance(right, int):
            text, times = (right, left) if isinstance(left, int) else (left, right)
            length = len(text) * max(0, times)
        else:
            raise LimitExceeded(f"{name} is not known for {_kind(left)} and {_kind(right)}")
        if length > MAX_LENGTH:
            raise LimitExceeded(
                f"a sequence is not repeated this often: it has {MAX_LENGTH} elements at most"
            )
        self.spend(length // PER_STEP)

    def unary(self, name: str, value: Any) -> Any:
        """Compute `-value`, `~value` or `not value`."""
        self.weigh(value)
        return self.kept(getattr(operator, name)(value))

    def compare(self, test: Callable[[Any, Any], Any], left: Any, right: Any) -> Any:
        """Compute a comparison or `in`."""
        if _is_array(left) or _is_array(right):
            if test in (operator.is_, operator.is_not):
                return test(left, right)
            flat = [self.element(v) if isinstance(v, (list, tuple)) else v for v in (left, right)]
            if any(isinstance(v, (list, tuple)) and any(map(_has_length, v)) for v in flat):
                raise LimitExceeded("an array is compared with numbers, not with lists of lists")
            if not all(_is_number(v) or _has_length(v) for v in (left, right)):
                raise LimitExceeded(f"{_kind(left)} and {_kind(right)} are not compared")
        self.weigh(left)
        self.weigh(right)
        return test(left, right)

    def item(self, owner: Any, index: Any) -> Any:
        """Return `owner[index]` for an integer or a slice."""
        parts = (index.start, index.stop, index.step) if isinstance(index, slice) else (index,)
        if any(_is_array(part) for part in parts):
            raise LimitExceeded("an index is a whole number or a slice, not an array")
        if not all(hasattr(part, "__index__") or (part is None and len(parts) == 3) for part in parts):
            raise LimitExceeded(f"an index is a whole number or a slice, not {_kind(index)}")
        return self.kept(owner[index])

    def call(self, name: str, arguments: list[Any]) -> Any:
        """Call one of `FUNCTIONS`."""
        if name not in _COST_NOTHING:
            for value in arguments:
                self.weigh(value)
        if name == "round" and len(arguments) > 1 and not _at_most(arguments[1], MAX_DIGITS):
            raise LimitExceeded(f"rounded to at most {MAX_DIGITS} digits")
        if name in ("int", "float") and any(_has_length(v) and len(v) > MAX_NUMBER_TEXT for v in arguments):
            raise LimitExceeded(f"a number has at most {MAX_NUMBER_TEXT} characters")
        if name == "sum":
            for value in arguments:
                if not _is_array(value) and not all(
                    map(_is_number, value if _has_length(value) else [value])
                ):
                    raise LimitExceeded("sum adds numbers")
        return self.kept(FUNCTIONS[name](*arguments))

    def method(self, owner: str, name: str, arguments: list[Any]) -> Any:
        """Call one of `STRING_METHODS`."""
        for value in (owner, *arguments):
            self.weigh(value)
        return self.kept(getattr(owner, name)(*arguments))


def _check_power(base: Any, exponent: Any) -> None:
    if isinstance(exponent, int) and (
        not _at_most(exponent, MAX_EXPONENT)
        or (isinstance(base, int) and base.bit_length() * abs(exponent) > MAX_BITS)
    ):
        raise LimitExceeded("numbers this large are not raised to a power")


def _check_fixed_width(left: Any, right: Any) -> None:
    """Refuse numbers beyond 64 bits: numpy would convert each element to an object."""
    if any(isinstance(value, int) and not _at_most(value, (1 << 63) - 1) for value in (left, right)):
        raise LimitExceeded("an array is combined with numbers of at most 63 bits")


def _at_most(value: Any, limit: int) -> bool:
    return value is None or (hasattr(value, "__index__") and abs(operator.index(value)) <= limit)


def _is_array(value: Any) -> bool:
    return hasattr(value, "dtype") and value.ndim > 0


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, complex)) or (hasattr(value, "dtype") and value.ndim == 0)


def _is_sequence(value: Any) -> bool:
    return isinstance(value, (str, bytes, bytearray, list, tuple))


def _has_length(value: Any) -> bool:
    return _is_sequence(value) or _is_array(value)


def _kind(value: Any) -> str:
    return str(getattr(value, "_type", type(value).__name__))
