"""Filter expressions compute values and can do nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rosproto.cli.expression import Expression, ExpressionError
from rosproto.time import Time


class Point:
    __slots__ = ("name", "ranges", "x", "y")
    _slot_types = ("string", "float32[]", "float64", "float64")
    _type = "test/Point"
    LIMIT = 5

    def __init__(self) -> None:
        self.x, self.y, self.name, self.ranges = 1.5, -2.0, "map", [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("m.x > 1", True),
        ("m.x > 1 and m.y > 0", False),
        ("0 < m.x < 2", True),
        ("m.name == 'map' or False", True),
        ("not m.name", False),
        ("m.name in ('map', 'odom')", True),
        ("m.name.startswith('m')", True),
        ("m.ranges[0] + m.ranges[-1]", 4.0),
        ("len(m.ranges[1:])", 2),
        ("min(m.ranges)", 1.0),
        ("any(r > 2.5 for r in m.ranges)", True),
        ("sum([r for r in m.ranges if r > 1])", 5.0),
        ("hypot(3, 4)", 5.0),
        ("m.x if m.y < 0 else 0", 1.5),
        ("-m.y ** 2", -4.0),
        ("m.LIMIT", 5),
        ("cos(pi)", -1.0),
    ],
)
def test_value(text: str, expected: object) -> None:
    """The harmless part of Python's expressions has Python's meaning."""
    assert Expression(text)(m=Point()) == expected


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("m.ranges / 0", [math.inf, math.inf, math.inf]),
        ("m.ranges[0] / (m.ranges[0] - 1)", math.inf),
        ("sum(m.ranges * 3e38) > 1", True),
        ("1if m.ranges[0] else 2", 1),
        (r"m.name == 'a\d'", False),
    ],
)
def test_no_warning_of_python_or_numpy(text: str, expected: object) -> None:
    """They would stand between the messages on a terminal; infinity is an answer."""
    point = Point()
    point.ranges = np.array([1, 2, 3], np.float32)  # type: ignore[assignment]
    found = Expression(text)(m=point)
    assert (found.tolist() if isinstance(found, np.ndarray) else found) == expected


@pytest.mark.promise("is checked before it is compiled", "Nothing else can be called")
@pytest.mark.parametrize(
    "text",
    [
        "__import__('os')",
        "m.__class__",
        "m._type",
        "(lambda: 1)()",
        "[x for x in ().__class__.__bases__]",
        "open('/etc/passwd')",
        "f'{m.x}'",
        "m.x := 3",
        "x",
        "m.x; m.y",
        "{1: 2}",
        "await m",
        "1 << 99999999",
        "m @ m",
        "len",
        "abs(m.x, *m.ranges)",
        "max(default=1)",
        "m.name.format(1)",
        "m.ranges.tofile('x')",
        "m.ranges[0](1)",
        "(len or max)(m.ranges)",
        "max(1) for max in [m.name.strip]",
        "[max(1) for max in [m.name.strip]]",
        "[x for x, y in m.ranges]",
        "[x for x in m.ranges if (y := x)]",
        "[x async for x in m.ranges]",
        "{x for x in m.ranges}",
        "m.x\0",
        "m." * 3000 + "x",
        "-" * 9000 + "1",
        "(" * 300 + "1" + ")" * 300,
        "",
    ],
)
def test_refused_when_typed(text: str) -> None:
    """What is outside the language is refused before any message comes."""
    with pytest.raises(ExpressionError):
        Expression(text)


@pytest.mark.parametrize(
    ("text", "column"),
    [("1 + open(2)", 5), ("m.x > m._type", 7), ("max(1, key=2)", 1), ("m.x + {1: 2}", 7), ("m.x > > 2", 7)],
)
def test_the_error_has_the_column(text: str, column: int) -> None:
    """It points at the part that is refused."""
    with pytest.raises(ExpressionError, match=rf"^filter .*, column {column}: ") as caught:
        Expression(text)
    assert caught.value.column == column


@pytest.mark.promise("Nothing else can be called")
@pytest.mark.parametrize(
    "text", ["(x for x in m.ranges).gi_frame", "m.name.lower", "m.ranges.ctypes", "m.x.real"]
)
def test_only_fields_are_read(text: str) -> None:
    """The attributes of Python's and numpy's own objects lead out of the message."""
    point = Point()
    point.ranges = np.array([1, 2, 3], np.float32)  # type: ignore[assignment]
    with pytest.raises(ExpressionError, match="has no field"):
        Expression(text)(m=point)


def test_functions_see_no_builtins() -> None:
    """Python adds its builtins to a scope that has none."""
    expression = Expression("max(m.x, 1)")
    assert expression(m=Point()) == 1.5
    assert Expression("m")(m=3) == 3
    with pytest.raises(ExpressionError, match="NameError"):
        Expression("[y for x in [1] if [y for y in [1]]]")(m=Point())


@pytest.mark.parametrize("text", ["m.z", "m.x.y", "m.ranges[7]", "m.name + 1", "m.x.count(1)", "int('a')"])
def test_refused_when_computed(text: str) -> None:
    """What does not fit the message is one clear error."""
    with pytest.raises(ExpressionError):
        Expression(text)(m=Point())


def test_times_are_converted() -> None:
    """As `to_sec` and `to_nsec` of rospy's times do."""
    assert Expression("t.to_sec() > 1.4 and t.to_nsec() == 1500000000", ("t",))(t=Time(1, 500000000)) is True


@pytest.mark.parametrize(
    ("text", "expected"), [("(r for r in m.ranges if r > 9)", []), ("len(r for r in m.ranges)", 3)]
)
def test_a_loop_makes_a_list(text: str, expected: object) -> None:
    """An empty one is false; a generator of Python would always be true."""
    assert Expression(text)(m=Point()) == expected


def test_an_error_names_the_fields_there_are() -> None:
    """A mistyped field is answered with the right ones."""
    with pytest.raises(ExpressionError, match="ranges, x, y") as caught:
        Expression("m.Y > 1")(m=Point())
    assert caught.value.text == "m.Y > 1"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("round(m.x, 1) == 1.5", True),
        ("m.name + '/' + 'odom' == 'map/odom'", True),
        ("max(m.ranges * 2) > 3 and (m.ranges + m.ranges)[1] == 2", True),
        ("m.x ** 2 + 1000000 ** 2 > 1e12", True),
        ("max(abs(m.ranges - 1))", 2998.0),
        ("any(m.ranges > 2) and not all(m.ranges[1:3] == m.ranges[2:4])", True),
        ("m.ranges[-1] % 10", 9.0),
        ("[m.ranges] == [[[x] for x in m.ranges]]", False),
        ("(1, 2) in [(1, 2)] and sorted([2, 1])[0] == 1", True),
        ("str(7) + 'a' * 3", "7aaa"),
        ("len([r for r in m.ranges if r > 2990])", 9),
    ],
)
def test_what_people_write_about_arrays(text: str, expected: object) -> None:
    """Arrays are numpy's; in a list they are lists, so that comparing does not broadcast them."""
    point = Point()
    point.ranges = np.arange(3000, dtype="f8")  # type: ignore[assignment]
    assert Expression(text)(m=point) == expected
