"""Values that users hand to messages beside the usual ones: told apart, or refused with a sentence."""

from __future__ import annotations

import numpy as np
import pytest

import rosproto
from rosproto.codec.dicts import from_dict, to_dict
from rosproto.codec.text import quoted, strify_message
from rosproto.errors import CodecError

Joy = rosproto.message_class("sensor_msgs/Joy")
Flags = rosproto.define(
    "edge_msgs/Flags", "bool[] many\nbool one\nfloat32[] rates\nstring text\ntime at\nint8[2] pair\n"
)


class NoBuffer:
    """A sequence of numbers that is neither list nor array."""

    def __init__(self, *items: object) -> None:
        self.items = items

    def __len__(self) -> int:
        return len(self.items)

    def __iter__(self):  # type: ignore[no-untyped-def]
        return iter(self.items)


@pytest.mark.parametrize(
    ("value", "says"),
    [
        (np.float64(1.0), "not one number|sequence"),
        ("true", "sequence is expected"),
    ],
)
def test_what_is_no_array_of_booleans_is_refused(value: object, says: str) -> None:
    """The text says what was expected."""
    with pytest.raises((CodecError, TypeError), match=says):
        rosproto.encode(Flags(many=value, pair=[0, 0]))


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (np.array([0, 2, 0]), [False, True, False]),
        (np.array([], dtype="U1"), []),
        (np.array([], dtype=float), []),
        (NoBuffer(1, 0), [True, False]),
        (np.ones(4, bool)[::2], [True, True]),
    ],
)
def test_arrays_of_other_kinds_become_booleans(value: object, expected: list[bool]) -> None:
    """Numbers by their truth, empty ones of any kind, and what has gaps."""
    back = rosproto.decode(Flags, rosproto.encode(Flags(many=value, pair=[0, 0])))
    assert list(back.many) == expected


def test_a_value_beyond_float32_is_refused() -> None:
    """It would become infinite without a word."""
    with pytest.raises((CodecError, OverflowError), match="out of range"):
        rosproto.encode(Flags(rates=np.array([1e300]), pair=[0, 0]))
    assert np.isinf(
        rosproto.decode(Flags, rosproto.encode(Flags(rates=np.array([np.inf]), pair=[0, 0]))).rates[0]
    )


def test_text_is_escaped_as_yaml_is() -> None:
    """Every character comes back from a YAML parser."""
    yaml = pytest.importorskip("yaml")
    text = 'a"b\\\n\t\0\x1b\x7f\x85\xa0\u2028\u8d27\U0001f600\xe9'
    assert yaml.safe_load(quoted(text)) == text
    assert quoted("") == "''"


def test_a_message_shows_every_kind_of_value() -> None:
    """Bytes, arrays, times, empty and nested lists."""
    shown = str(Flags(many=np.array([True]), rates=[], text="x", at=rosproto.Time(1, 2), pair=b"\1\2"))
    assert "many: [True]" in shown
    assert "rates: []" in shown
    assert "pair: [1, 2]" in shown
    assert "secs: 1" in shown
    assert strify_message([[1], [2]]) == "\n- [1]\n- [2]"
    assert strify_message(None) == "None"


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"one": "yes"}, "is not a bool"),
        ({"many": 1}, "is not a list"),
        ({"text": []}, "is not a string"),
        ({"at": "later"}, "is not a time"),
        ({"rates": ["fast"]}, "is not a valid float32"),
        ({"pair": [0.5, 1]}, "is not a valid int8"),
    ],
)
def test_wrong_values_typed_by_a_person_are_named(values: dict[str, object], says: str) -> None:
    """The text holds the value and the kind that was asked for."""
    with pytest.raises((CodecError, ValueError, TypeError), match=says):
        from_dict(Flags, values)


@pytest.mark.parametrize(
    "at", [{"secs": 3}, [3, 0], 3.0, 3_000_000_000, rosproto.Time(3, 0), rosproto.Duration(3, 0)]
)
def test_a_time_may_be_written_in_many_ways(at: object) -> None:
    """As a mapping, a pair, seconds with a point, nanoseconds without, or a time."""
    assert from_dict(Flags, {"at": at, "text": "7", "one": 1, "many": b"\1"}).at.secs == 3


def test_a_dict_of_a_message_has_plain_values() -> None:
    """Lists, numbers and strings only."""
    found = to_dict(Joy(axes=[1.0], buttons=np.array([1, 2], np.int32)))
    assert found["axes"] == [1.0]
    assert found["buttons"] == [1, 2]
    assert found["header"]["stamp"] == {"secs": 0, "nsecs": 0}
