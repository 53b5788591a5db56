"""Messages as rosbridge's JSON, and back; tests/interop/test_rosbridge_values.py holds both to the original."""

from __future__ import annotations

import base64
import json
import math
from typing import Any

import numpy as np
import pytest

from rosproto.codec import decode, define, encode, message_class, service_class
from rosproto.errors import CodecError
from rosproto.gateway.json_writer import PIECE
from rosproto.gateway.values import from_arguments, from_values, to_json
from rosproto.msg import bundled
from rosproto.time import Time
from tests.support.rosbridge_values import to_values

NOW = Time(1234, 5678)

ALL = """
bool flag
int8 small
uint64 large
float32 single
float64 double
string text
time stamp
duration span
bool[] flags
int32[] integers
float32[] singles
float64[2] pair
uint8[] octets
char[3] three
int8[] signed
string[] texts
time[] stamps
duration[1] spans
geometry_msgs/Point point
geometry_msgs/Point[] points
std_msgs/Header header
std_msgs/Header[] headers
"""


EVERYTHING = define("test_msgs/Everything", ALL, base=bundled())
GRID = define("a/Grid", "int8[] data")
HEADER = message_class("std_msgs/Header")
POSE = message_class("geometry_msgs/PoseStamped")

VALUES: dict[str, Any] = {
    "flag": True, "small": -128, "large": 2**64 - 1, "single": 0.5, "double": -1e300, "text": 'Wüste "\\\n\u0007地',
    "stamp": {"secs": 1, "nsecs": 2}, "span": {"secs": -1, "nsecs": 999_999_999}, "flags": [True, False],
    "integers": [1, -2, 3], "singles": [0.25, 1e10], "pair": [1.0, 2.0], "octets": base64.b64encode(b"\0\xff").decode(),
    "three": base64.b64encode(b"abc").decode(), "signed": [-1, 127], "texts": ["", 'a"b'],
    "stamps": [{"secs": 1, "nsecs": 0}, {"secs": 4294967295, "nsecs": 0}], "spans": [{"secs": 0, "nsecs": -5}],
    "point": {"x": 1.0, "y": 2.0, "z": 3.0}, "points": [{"x": 0.0, "y": 0.0, "z": -1.0}],
    "header": {"seq": 3, "stamp": {"secs": 9, "nsecs": 8}, "frame_id": "map"},
    "headers": [{"seq": 0, "stamp": {"secs": 0, "nsecs": 0}, "frame_id": ""}],
}  # fmt: skip


def sent(cls: Any, values: Any, now: Time | None = NOW) -> Any:
    """The values of a message that a client sends, after the wire of ROS."""
    return to_values(decode(cls, encode(from_values(cls, values, now=now))))


def wrong(cls: Any, values: Any, now: Time | None = NOW) -> str:
    with pytest.raises(CodecError) as caught:
        from_values(cls, values, now=now)
    assert len(str(caught.value)) < 400
    return str(caught.value)


def test_every_kind_of_field_round_trip() -> None:
    """Out as rosbridge has them, and in again the same."""
    assert sent(EVERYTHING, VALUES) == VALUES
    assert sent(EVERYTHING, {**VALUES, "octets": [0, 255], "three": list(b"abc")}) == VALUES


def test_the_text_is_plain_ascii() -> None:
    """Characters beyond ASCII are escaped: also those that UTF-8 has no bytes for."""
    message = EVERYTHING(text="地\udcff")
    assert to_json(message).isascii()
    assert json.loads(to_json(message))["text"] == "地\udcff"


def test_nan_and_infinity_are_null() -> None:
    """Wherever they are; and other numbers keep every digit."""
    message = EVERYTHING(single=math.nan, double=-math.inf, pair=[math.nan, 0.1])
    message.singles = np.array([np.nan, -np.inf, np.inf, 0.1, -0.0], "f4")
    values = to_values(message)
    assert (values["single"], values["double"], values["pair"]) == (None, None, [None, 0.1])
    assert values["singles"] == [None, None, None, 0.10000000149011612, 0.0]


def test_what_a_program_put_in() -> None:
    """A message that was not decoded has lists, integers for floats, numpy's numbers: the same text."""
    message = EVERYTHING(
        single=1, double=np.float64(0.5), flags=[1, 0], singles=[1, 2], octets=b"\0", signed=[1]
    )
    message.integers = np.arange(6, dtype="<i4")[::2]
    values = to_values(message)
    assert values == to_values(decode(EVERYTHING, encode(message)))
    assert (values["single"], values["double"], values["singles"], values["octets"]) == (
        1.0,
        0.5,
        [1.0, 2.0],
        "AA==",
    )
    with pytest.raises(CodecError, match="single"):
        to_json(EVERYTHING(single="no number"))


@pytest.mark.parametrize(
    "octets", [b"\1\2", bytearray(b"\1\2"), [1, 2], (1, 2), np.array([1, 2]), np.array([1, 9, 2], "u1")[::2]]
)
def test_octets_of_every_kind(octets: Any) -> None:
    """Whatever the codec takes for bytes is base64 of these bytes."""
    assert to_values(EVERYTHING(octets=octets))["octets"] == base64.b64encode(b"\1\2").decode()


@pytest.mark.parametrize("count", [0, 1, 99, 100, 101, 1 << 17, (1 << 18) + 1])
@pytest.mark.parametrize("least", [-128, -100, -99, 0])
def test_small_integers_of_any_number(count: int, least: int) -> None:
    """The cells of a map: long arrays take another way than short ones, and than those with -128."""
    cells = np.resize(np.arange(least, 128, dtype="i1"), count)
    text = to_json(decode(GRID, encode(GRID(data=cells))))
    if count < 1000:
        assert json.loads(text)["data"] == cells.tolist()
    else:
        inside = text[text.index("[") + 1 : text.index("]")]
        assert np.array_equal(np.array(inside.split(","), "i1"), cells)
    assert to_values(GRID(data=cells[:300][::2]))["data"] == cells[:300][::2].tolist()


@pytest.mark.parametrize("count", [PIECE - 1, PIECE, PIECE + 1, 2 * PIECE, 2 * PIECE + 1])
def test_long_arrays_are_written_in_pieces(count: int) -> None:
    """Every number is there once, in its place, also NaN at the seams."""
    message = EVERYTHING(integers=np.arange(count, dtype="<i4"), singles=np.arange(count, dtype="<f4"))
    message.singles[[PIECE - 2, -1]] = np.nan
    values = to_values(decode(EVERYTHING, encode(message)))
    assert values["integers"] == list(range(count))
    assert [i for i, value in enumerate(values["singles"]) if value != i] == sorted({PIECE - 2, count - 1})
    assert values["singles"][-1] is None


def test_empty_messages() -> None:
    """A type without fields, and services'."""
    empty = message_class("std_msgs/Empty")
    assert to_json(empty()) == "{}"
    assert sent(empty, {}) == {}
    assert to_json(service_class("std_srvs/SetBool").Request(data=True)) == '{"data":true}'


def test_a_field_that_is_a_keyword() -> None:
    """By its own name."""
    cls = message_class("woosh_msgs/NavMode")
    values = to_values(cls())
    assert "in" in values
    assert sent(cls, values) == values


def test_hundreds_of_fields() -> None:
    """Longer than one expression of generated code may be."""
    cls = define("a/Wide", "\n".join(f"int32 f{number}" for number in range(1000)))
    values = {f"f{number}": number for number in range(1000)}
    assert sent(cls, values) == values


def test_headers_are_stamped() -> None:
    """A Header that is named gets the time, unless it brings its own; one that is left out stays empty."""
    stamp, none = {"secs": 1234, "nsecs": 5678}, {"secs": 0, "nsecs": 0}
    assert sent(POSE, {"header": {"frame_id": "map"}})["header"] == {
        "seq": 0,
        "stamp": stamp,
        "frame_id": "map",
    }
    assert sent(POSE, {"header": {"stamp": "now"}})["header"]["stamp"] == stamp
    assert sent(POSE, {"header": {"stamp": {}}})["header"]["stamp"] == stamp
    assert sent(POSE, {"header": {"stamp": {"secs": 5, "nsecs": 6}}})["header"]["stamp"] == {
        "secs": 5,
        "nsecs": 6,
    }
    assert sent(POSE, {})["header"]["stamp"] == none
    assert sent(POSE, {"header": {}}, now=None)["header"]["stamp"] == none
    assert sent(HEADER, {})["stamp"] == stamp
    headers = sent(EVERYTHING, {"headers": [{}, {"stamp": {"secs": 1, "nsecs": 1}}]})["headers"]
    assert [header["stamp"] for header in headers] == [stamp, {"secs": 1, "nsecs": 1}]


def test_the_default_of_a_class_is_not_changed() -> None:
    """Each message has its own stamp."""
    first = from_values(POSE, {"header": {}}, now=NOW)
    first.header.stamp.secs = 7
    assert from_values(POSE, {"header": {}}, now=NOW).header.stamp.secs == 1234
    assert POSE().header.stamp.secs == 0


@pytest.mark.promise("nothing it sends raises an exception outside the protocol code")
@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        (None, "test_msgs/Everything: null given; expected an object with the fields of test_msgs/Everything"),
        ([], "test_msgs/Everything: an array of 0 given; expected an object"),
        ("x", "test_msgs/Everything: 'x' given; expected an object"),
        ({"flug": 1}, "test_msgs/Everything: test_msgs/Everything has no field 'flug'; it has: flag, small"),
        ({"point": {"w": 1}}, "test_msgs/Everything.point: geometry_msgs/Point has no field 'w'; it has: x, y, z"),
        ({"point": 5}, "test_msgs/Everything.point: 5 given; expected an object with the fields of geometry_msgs/Point"),
        ({"point": {"x": "1"}}, "test_msgs/Everything.point.x: '1' given; expected a number"),
        ({"points": [{}, {"x": None}]}, "test_msgs/Everything.points[1].x: null given; expected a number"),
        ({"points": {}}, "test_msgs/Everything.points: an object of 0 given; expected an array"),
        ({"flag": 1}, "test_msgs/Everything.flag: 1 given; expected true or false"),
        ({"flags": [True, 0]}, "test_msgs/Everything.flags[1]: 0 given; expected true or false"),
        ({"small": 128}, "test_msgs/Everything.small: 128 given; expected -128 to 127"),
        ({"small": 1.0}, "test_msgs/Everything.small: 1.0 given; expected a whole number"),
        ({"small": True}, "test_msgs/Everything.small: true given; expected a whole number"),
        ({"large": -1}, "test_msgs/Everything.large: -1 given; expected 0 to 18446744073709551615"),
        ({"large": 10**400}, "test_msgs/Everything.large: a number of more than 64 bits given; expected 0 to"),
        ({"double": 10**400}, "test_msgs/Everything.double: a number of more than 64 bits given; expected a number"),
        ({"double": True}, "test_msgs/Everything.double: true given; expected a number"),
        ({"single": 1e300}, "test_msgs/Everything.single: 1e+300 given; expected a number within float32"),
        ({"text": 5}, "test_msgs/Everything.text: 5 given; expected a text"),
        ({"texts": ["a", None]}, "test_msgs/Everything.texts[1]: null given; expected a text"),
        ({"text": "a\udcff"}, "test_msgs/Everything.text: half a character (surrogate U+DCFF) at 1; expected a text of"),
        ({"texts": ["ä", "\ud800"]}, "test_msgs/Everything.texts[1]: half a character (surrogate U+D800) at 0;"),
        ({"texts": "abc"}, "test_msgs/Everything.texts: 'abc' given; expected an array"),
        ({"integers": [1, 2**31]}, "test_msgs/Everything.integers[1]: 2147483648 given; expected -2147483648 to"),
        ({"integers": [1, 2.5]}, "test_msgs/Everything.integers[1]: 2.5 given; expected a whole number"),
        ({"integers": [True]}, "test_msgs/Everything.integers[0]: true given; expected a whole number"),
        ({"singles": [1, "x"]}, "test_msgs/Everything.singles[1]: 'x' given; expected a number"),
        ({"singles": [1, 1e300]}, "test_msgs/Everything.singles[1]: 1e+300 given; expected a number within float32"),
        ({"singles": [10**400]}, "test_msgs/Everything.singles[0]: a number of more than 64 bits given"),
        ({"pair": [1.0]}, "test_msgs/Everything.pair: 1 elements given; expected 2"),
        ({"three": "AAA="}, "test_msgs/Everything.three: 2 elements given; expected 3"),
        ({"three": [1, 2, 3, 4]}, "test_msgs/Everything.three: 4 elements given; expected 3"),
        ({"octets": "not base64!"}, "test_msgs/Everything.octets: no base64: "),
        ({"octets": "AAA"}, "test_msgs/Everything.octets: no base64: Incorrect padding"),
        ({"octets": "Ä"}, "test_msgs/Everything.octets: no base64: "),
        ({"octets": [256]}, "test_msgs/Everything.octets[0]: 256 given; expected 0 to 255"),
        ({"octets": 5}, "test_msgs/Everything.octets: 5 given; expected an array, or its bytes as base64"),
        ({"spans": []}, "test_msgs/Everything.spans: 0 elements given; expected 1"),
        ({"stamp": 5}, 'test_msgs/Everything.stamp: 5 given; expected an object {"secs", "nsecs"}, or "now"'),
        ({"stamp": None}, "test_msgs/Everything.stamp: null given; expected an object"),
        ({"stamp": {"sec": 1, "nanosec": 2}}, "test_msgs/Everything.stamp: an object of 2 given; expected an object"),
        ({"stamp": {"secs": -1}}, "test_msgs/Everything.stamp.secs: -1 given; expected a whole number from 0 to"),
        ({"stamp": {"secs": 1.5}}, "test_msgs/Everything.stamp.secs: 1.5 given; expected a whole number from 0 to"),
        ({"span": "now"}, "test_msgs/Everything.span: 'now' given; expected an object"),
        ({"stamps": ["now", 1]}, "test_msgs/Everything.stamps[1]: 1 given; expected an object"),
        ({"header": None}, "test_msgs/Everything.header: null given; expected an object with the fields of std_msgs/H"),
        ({"text": "x" * 10_000, "flag": "y" * 10_000}, "test_msgs/Everything.flag: 'yyyy"),
    ],
)  # fmt: skip
def test_wrong_values(values: Any, sentence: str) -> None:
    """The field, what was given, and what was expected."""
    assert wrong(EVERYTHING, values).startswith(sentence)


def test_now_needs_a_clock() -> None:
    """Without one it is refused, not taken for zero."""
    assert wrong(EVERYTHING, {"stamp": "now"}, now=None).endswith(
        "'now' means nothing here: there is no clock"
    )


def test_arguments_of_a_call() -> None:
    """By field, by position, fewer than there are, none; more are refused."""
    cls = message_class("geometry_msgs/Point")
    assert to_values(from_arguments(cls, {"y": 2})) == {"x": 0.0, "y": 2.0, "z": 0.0}
    assert to_values(from_arguments(cls, [1, 2])) == {"x": 1.0, "y": 2.0, "z": 0.0}
    assert (
        to_values(from_arguments(cls, None))
        == to_values(from_arguments(cls, []))
        == {"x": 0.0, "y": 0.0, "z": 0.0}
    )
    with pytest.raises(CodecError, match="4 arguments given, but it has the fields: x, y, z"):
        from_arguments(cls, [1, 2, 3, 4])
    with pytest.raises(CodecError, match="'x' given; expected an object"):
        from_arguments(cls, "x")


def test_classes_of_rospys_values() -> None:
    """The value style of unchanged rospy programs: tuples and bytes."""
    cls = define("test_msgs/Everything", ALL, base=bundled(), value_style="rospy")
    assert sent(cls, VALUES) == VALUES
