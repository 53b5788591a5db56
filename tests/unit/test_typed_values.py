"""Values on a command line are read as by PyYAML, and so rospy and rosparam; JSON as JSON."""

from __future__ import annotations

import json
import math

import pytest

from rosproto.typed_values import parse_value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("-5", -5),
        ("+5", 5),
        ("0x1F", 31),
        ("-0x1F", -31),
        ("0b101", 5),
        ("017", 15),
        ("1_000", 1000),
        ("0", 0),
        ("-0", 0),
        ("1.5", 1.5),
        (".5", 0.5),
        ("1.", 1.0),
        ("-1.5e3", -1500.0),
        ("1e3", 1000.0),
        ("0o17", "0o17"),
        ("1:30", 90),
        ("-1:30:00.5", -5400.5),
        ("deg(90)", math.pi / 2),
        ("[rad(pi/2), 'deg(90)', deg 90]", [math.pi / 2, "deg(90)", "deg 90"]),
        ("{2: a, yes: b, '2': c}", {2: "a", True: "b", "2": "c"}),
        (".inf", math.inf),
        ("-.INF", -math.inf),
        ("true", True),
        ("False", False),
        ("yes", True),
        ("OFF", False),
        ("", None),
        ("~", None),
        ("null", None),
        ("map", "map"),
        ("two words", "two words"),
        ("/a/b", "/a/b"),
        ("192.168.0.1", "192.168.0.1"),
        ("08", "08"),
        ("1-2", "1-2"),
        ("--1", "--1"),
        ("-", "-"),
        ("inf", "inf"),
        ("nan", "nan"),
        ("1e", "1e"),
        ("\u0663", "\u0663"),
        ("tRuE", "tRuE"),
        ('"1"', "1"),
        ("'it''s'", "it's"),
        (r'"a\n\x41\u00e9\"\\"', 'a\nA\u00e9"\\'),
        (r'"\ud83d\ude00"', "\U0001f600"),
        ("a, b", "a, b"),
        ("[]", []),
        ("{}", {}),
        ("[1, two, 'three', [4.0], {five: 5}]", [1, "two", "three", [4.0], {"five": 5}]),
        ("[1, 2,]", [1, 2]),
        ("{a: 1, 'b c': [x, y], d: {e: no}}", {"a": 1, "b c": ["x", "y"], "d": {"e": False}}),
        ("{url: http://a/b}", {"url": "http://a/b"}),
        ("  [ 1 ,  2 ]  ", [1, 2]),
        ("{a: }", {"a": None}),
    ],
)
def test_values(text: str, value: object) -> None:
    """The type matters as much as the value."""
    found = parse_value(text)
    assert found == value
    assert type(found) is type(value)


def test_not_a_number() -> None:
    """YAML's own spelling only."""
    found = parse_value(".nan")
    assert isinstance(found, float)
    assert math.isnan(found)


@pytest.mark.parametrize(
    "value", [None, True, 1, -2.5e-7, 'a"b\\\n\u4e2d\U0001f600', [], {"a": [1, {"b": None}]}, 1e22]
)
@pytest.mark.parametrize("ascii_only", [True, False])
def test_every_json_text_is_a_value(value: object, ascii_only: bool) -> None:
    """Tools write JSON; it reads the same here."""
    assert parse_value(json.dumps(value, ensure_ascii=ascii_only)) == value


@pytest.mark.parametrize(
    "text",
    [
        "[1, 2",
        "{a: 1",
        "{a}",
        "{: 1}",
        "'a",
        '"a',
        '"\\q"',
        '"\\x4"',
        "[1] 2",
        "{a: 1} x",
        "[1 [2]]x",
        "[" * 1000,
    ],
)
def test_what_is_not_closed_is_refused(text: str) -> None:
    """With the place where it went wrong."""
    with pytest.raises(ValueError, match="at character"):
        parse_value(text)
