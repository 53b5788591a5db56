"""Time and Duration: seconds and nanoseconds, with genpy's arithmetic and without a clock.

Source: wiki.ros.org/msg (time: two uint32, duration: two int32) and genpy.rostime, on whose behaviour
programs rely. `Time.now()` needs a clock and belongs to the node.
"""

from __future__ import annotations

from typing import SupportsFloat, TypeVar, overload

from rosproto.coercion import as_float

__all__ = ["Duration", "TVal", "Time"]

_NSEC = 1_000_000_000
_Self = TypeVar("_Self", bound="TVal")


class TVal:
    """Base of Time and Duration.

    The constructor normalises values (0 <= nsecs < 1e9). Values read from the wire are kept unchanged, also
    with nsecs >= 1e9, so that forwarding a message changes nothing; `canon()` normalises on demand.

    Attributes:
        secs: Whole seconds.
        nsecs: Nanoseconds in addition to them.
    """

    __slots__ = ("secs", "nsecs")  # noqa: RUF023  the order of the wire, as genpy has it
    _slot_types = ("int32", "int32")

    secs: int
    nsecs: int

    def __init__(self, secs: float = 0, nsecs: int = 0) -> None:
        """Take whole seconds and nanoseconds, or float seconds alone.

        Raises:
            ValueError: `secs` is a float and `nsecs` is not 0.
        """
        secs = secs if isinstance(secs, int) else as_float(secs)
        whole = int(secs)
        if isinstance(secs, int) or whole == secs:
            rest = int(nsecs)
        elif nsecs == 0:
            rest = int((secs - whole) * _NSEC)
        else:
            raise ValueError(f"float secs ({secs!r}) hold the fraction already: omit nsecs")
        over = rest // _NSEC
        self.secs = whole + over
        self.nsecs = rest - over * _NSEC

    @classmethod
    def from_wire(cls: type[_Self], secs: int, nsecs: int) -> _Self:
        """Make one from wire values, unchanged and unchecked."""
        self = object.__new__(cls)
        self.secs = secs
        self.nsecs = nsecs
        return self

    @classmethod
    def from_sec(cls: type[_Self], float_secs: float) -> _Self:
        """Make one from float seconds (the scale of `time.time()`); the fraction is cut, not rounded."""
        float_secs = as_float(float_secs)
        whole = int(float_secs)
        return cls(whole, int((float_secs - whole) * _NSEC))

    @classmethod
    def from_seconds(cls: type[_Self], float_secs: float) -> _Self:
        """The old rospy name of `from_sec`."""
        return cls.from_sec(float_secs)

    @classmethod
    def from_nsec(cls: type[_Self], nsecs: int) -> _Self:
        """Make one from integer nanoseconds; exact, where `from_sec` is limited to float64."""
        return cls(0, nsecs)

    def is_zero(self) -> bool:
        """True when both parts are 0."""
        return self.secs == 0 and self.nsecs == 0

    def set(self, secs: int, nsecs: int) -> None:
        """Set both parts as they are."""
        self.secs = secs
        self.nsecs = nsecs

    def canon(self) -> None:
        """Bring to 0 <= nsecs < 1e9, in place."""
        over = self.nsecs // _NSEC
        self.secs += over
        self.nsecs -= over * _NSEC

    def to_sec(self) -> float:
        """Seconds as float64 (for a time of today exact to about 0.2 µs)."""
        return float(self.secs) + float(self.nsecs) / 1e9

    def to_nsec(self) -> int:
        """Nanoseconds, exact."""
        return self.secs * _NSEC + self.nsecs

    def _order_key(self, other: object) -> int | None:
        """`other` in nanoseconds if it can be compared with this, else None."""
        return other.to_nsec() if isinstance(other, TVal) else None

    def __lt__(self, other: object) -> bool:
        key = self._order_key(other)
        return NotImplemented if key is None else self.to_nsec() < key

    def __le__(self, other: object) -> bool:
        key = self._order_key(other)
        return NotImplemented if key is None else self.to_nsec() <= key

    def __gt__(self, other: object) -> bool:
        key = self._order_key(other)
        return NotImplemented if key is None else self.to_nsec() > key

    def __ge__(self, other: object) -> bool:
        key = self._order_key(other)
        return NotImplemented if key is None else self.to_nsec() >= key

    def __eq__(self, other: object) -> bool:
        return isinstance(other, TVal) and self.to_nsec() == other.to_nsec()

    def __hash__(self) -> int:
        return hash((self.secs, self.nsecs))

    def __bool__(self) -> bool:
        return self.secs != 0 or self.nsecs != 0

    def __str__(self) -> str:
        return str(self.to_nsec())

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.secs}, {self.nsecs})"

    def __getstate__(self) -> list[int]:
        return [self.secs, self.nsecs]

    def __setstate__(self, state: list[int]) -> None:
        self.secs, self.nsecs = state

    def __reduce__(self) -> tuple[object, ...]:
        # Not through __init__, which would normalise a raw wire value.
        return _restore, (type(self), self.secs, self.nsecs)


def _restore(cls: type[_Self], secs: int, nsecs: int) -> _Self:
    """Unpickle one, unchanged."""
    return cls.from_wire(secs, nsecs)


class Time(TVal):
    """A point in time: seconds since 1970-01-01 UTC, or of the simulated clock.

    On the wire secs and nsecs are uint32, so times end in 2106.
    """

    __slots__ = ()

    def __init__(self, secs: float = 0, nsecs: int = 0) -> None:
        """See `TVal`.

        Raises:
            TypeError: The result is negative.
        """
        super().__init__(secs, nsecs)
        if self.secs < 0:
            raise TypeError(
                f"time values must be positive, not {self.to_nsec()} ns; a Duration may be negative"
            )

    def to_time(self) -> float:
        """The same as `to_sec`: seconds on the scale of `time.time()`."""
        return self.to_sec()

    def _order_key(self, other: object) -> int | None:
        return other.to_nsec() if isinstance(other, Time) else None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Time) and self.secs == other.secs and self.nsecs == other.nsecs

    __hash__ = TVal.__hash__

    def __add__(self, other: Duration) -> Time:
        """Time + Duration -> Time."""
        if not isinstance(other, Duration):
            return NotImplemented
        return type(self)(self.secs + other.secs, self.nsecs + other.nsecs)

    __radd__ = __add__

    @overload
    def __sub__(self, other: Time) -> Duration: ...
    @overload
    def __sub__(self, other: Duration) -> Time: ...
    def __sub__(self, other: Time | Duration) -> Time | Duration:
        """Time - Time -> Duration; Time - Duration -> Time."""
        if isinstance(other, Time):
            return Duration(self.secs - other.secs, self.nsecs - other.nsecs)
        if isinstance(other, Duration):
            return type(self)(self.secs - other.secs, self.nsecs - other.nsecs)
        return NotImplemented


class Duration(TVal):
    """A span of time; may be negative. On the wire secs and nsecs are int32 (about 68 years)."""

    __slots__ = ()

    def _order_key(self, other: object) -> int | None:
        return other.to_nsec() if isinstance(other, Duration) else None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Duration) and self.secs == other.secs and self.nsecs == other.nsecs

    __hash__ = TVal.__hash__

    def __neg__(self) -> Duration:
        return type(self)(-self.secs, -self.nsecs)

    def __abs__(self) -> Duration:
        return self if self.secs >= 0 else -self

    def __add__(self, other: Duration) -> Duration:
        """Duration + Duration -> Duration (Duration + Time is Time's own)."""
        if not isinstance(other, Duration):
            return NotImplemented
        return type(self)(self.secs + other.secs, self.nsecs + other.nsecs)

    __radd__ = __add__

    def __sub__(self, other: Duration) -> Duration:
        if not isinstance(other, Duration):
            return NotImplemented
        return type(self)(self.secs - other.secs, self.nsecs - other.nsecs)

    def __mul__(self, factor: SupportsFloat) -> Duration:
        """Duration * number -> Duration; exact for whole numbers."""
        from numbers import Integral, Real  # late, here and below: abstract classes cost time to import

        if isinstance(factor, Integral):
            return type(self)(self.secs * int(factor), self.nsecs * int(factor))
        if isinstance(factor, Real):
            return type(self).from_sec(self.to_sec() * float(factor))
        return NotImplemented

    __rmul__ = __mul__

    @overload
    def __floordiv__(self, divisor: Duration) -> int: ...
    @overload
    def __floordiv__(self, divisor: SupportsFloat) -> Duration: ...
    def __floordiv__(self, divisor: Duration | SupportsFloat) -> int | Duration:
        """Duration // Duration -> int; Duration // number -> Duration."""
        from numbers import Real

        if isinstance(divisor, Real):
            return type(self).from_sec(self.to_sec() // float(divisor))
        if isinstance(divisor, Duration):
            return int(self.to_sec() // divisor.to_sec())
        return NotImplemented

    @overload
    def __truediv__(self, divisor: Duration) -> float: ...
    @overload
    def __truediv__(self, divisor: SupportsFloat) -> Duration: ...
    def __truediv__(self, divisor: Duration | SupportsFloat) -> float | Duration:
        """Duration / Duration -> float; Duration / number -> Duration."""
        from numbers import Real

        if isinstance(divisor, Real):
            return type(self).from_sec(self.to_sec() / float(divisor))
        if isinstance(divisor, Duration):
            return self.to_sec() / divisor.to_sec()
        return NotImplemented

    def __mod__(self, divisor: Duration) -> Duration:
        """Duration % Duration -> Duration, the rest of the division."""
        if not isinstance(divisor, Duration):
            return NotImplemented
        return type(self).from_sec(self.to_sec() % divisor.to_sec())

    def __divmod__(self, divisor: Duration) -> tuple[int, Duration]:
        """The pair (Duration // Duration, Duration % Duration)."""
        if not isinstance(divisor, Duration):
            return NotImplemented
        quotient, rest = divmod(self.to_sec(), divisor.to_sec())
        return int(quotient), type(self).from_sec(rest)


# Tools iterate over `__slots__` of messages and times alike. The slots themselves belong to TVal.
Time.__slots__ = Duration.__slots__ = TVal.__slots__  # type: ignore[assignment]
