"""Time and Duration: genpy's arithmetic, raw wire values kept."""

from __future__ import annotations

import copy
import pickle

import pytest

from rosproto.time import Duration, Time, TVal


def test_constructor_is_canonical() -> None:
    """0 <= nsecs < 1e9; negative durations count down from whole seconds."""
    assert (Time(1, 2_500_000_000).secs, Time(1, 2_500_000_000).nsecs) == (3, 500_000_000)
    assert (Duration(0, -1).secs, Duration(0, -1).nsecs) == (-1, 999_999_999)
    assert (Duration(-1.5).secs, Duration(-1.5).nsecs) == (-2, 500_000_000)
    assert Time(1.5) == Time(1, 500_000_000)
    assert list(Time.__slots__) == list(Duration.__slots__) == ["secs", "nsecs"]


def test_constructor_refuses_nonsense() -> None:
    """Two fractions, negative times."""
    with pytest.raises(ValueError, match="omit nsecs"):
        Time(1.5, 1)
    with pytest.raises(TypeError, match="must be positive"):
        Time(-1)
    with pytest.raises(AttributeError):
        Time().seconds = 1  # type: ignore[attr-defined]


@pytest.mark.promise("A time on the wire may have more")
def test_wire_values_are_kept_raw() -> None:
    """canon() brings them to normal form, nothing else does, not even a copy or a pickle."""
    raw = Time.from_wire(1, 1_500_000_000)
    for same in (raw, copy.copy(raw), copy.deepcopy(raw), pickle.loads(pickle.dumps(raw))):
        assert (same.secs, same.nsecs) == (1, 1_500_000_000)
    assert raw.to_nsec() == 2_500_000_000
    raw.canon()
    assert (raw.secs, raw.nsecs) == (2, 500_000_000)


def test_conversions() -> None:
    """Seconds, nanoseconds, text and truth."""
    assert Time(3, 250_000_000).to_sec() == Time(3, 250_000_000).to_time() == 3.25
    assert Time.from_sec(3.25) == Time.from_seconds(3.25) == Time(3, 250_000_000)
    assert Time.from_nsec(3_250_000_000) == Time(3, 250_000_000)
    assert Duration.from_sec(-0.5).to_nsec() == -500_000_000
    assert str(Time(1, 5)) == "1000000005"
    assert repr(Time(1, 5)) == "Time(1, 5)"
    assert not Time()
    assert Time().is_zero()
    assert Duration(0, 1)


def test_arithmetic_between_times_and_durations() -> None:
    """What genpy allows, with the same types as results."""
    assert Time(5) - Time(3, 1) == Duration(1, 999_999_999)
    assert Time(5) + Duration(1) == Duration(1) + Time(5) == Time(6)
    assert Time(5) - Duration(1) == Time(4)
    assert Duration(5) + Duration(1, 1) == Duration(6, 1)
    assert Duration(1) - Duration(2) == -Duration(1)
    assert abs(Duration(-2)) == Duration(2)
    assert Duration(1, 500_000_000) * 2 == 2 * Duration(1, 500_000_000) == Duration(3)
    assert Duration(3) * 0.5 == Duration(3) / 2 == Duration(1, 500_000_000)
    assert Duration(3) / Duration(2) == 1.5
    assert Duration(3) // Duration(2) == 1
    assert Duration(3) // 2 == Duration(1)
    assert Duration(3) % Duration(2) == Duration(1)
    assert divmod(Duration(3), Duration(2)) == (1, Duration(1))


@pytest.mark.parametrize(
    "expression",
    ["Time(1) + Time(1)", "Time(1) + 1", "Duration(1) - 1", "Time(1) * 2", "Duration(1) - Time(1)"],
)
def test_senseless_arithmetic_is_a_type_error(expression: str) -> None:
    """A number has no unit here."""
    with pytest.raises(TypeError):
        eval(expression)


def test_comparison_and_hash() -> None:
    """By value, within one type; ordering a time against a duration is an error."""
    assert Time(1) < Time(1, 1) <= Time(1, 1)
    assert Duration(-1) < Duration(0) < Duration(0, 1)
    assert Time(2) > Time(1) >= Time(1)
    assert Time(1) != Duration(1)
    assert Time(1) != 1
    assert hash(Time(1, 2)) == hash(Time(1, 2))
    assert len({Time(1), Time(1), Time(2)}) == 2
    with pytest.raises(TypeError):
        _ = Time(1) < Duration(1)
    with pytest.raises(TypeError):
        _ = Time(1) < 1


def test_subclasses_stay_what_they_are() -> None:
    """rospy.Time is a subclass; arithmetic with it gives rospy.Time again."""

    class Stamp(Time):
        pass

    assert type(Stamp(1) + Duration(1)) is Stamp
    assert type(Stamp.from_sec(1.5)) is Stamp
    assert isinstance(Stamp(1), TVal)
    assert Stamp(1) == Time(1)
