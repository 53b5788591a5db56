"""Filter expressions compute values and can do nothing else."""

from __future__ import annotations

import pytest

from rosproto.cli import expression
from rosproto.cli.expression import Expression, ExpressionError


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
        "m." * 3000 + "x",
        "",
    ],
)
def test_refused_when_typed(text: str) -> None:
    """What is outside the language is refused before any message comes."""
    with pytest.raises(ExpressionError):
        Expression(text)


@pytest.mark.parametrize(
    "text",
    [
        "9**9**9**9",
        "'a' * 10**9",
        "m.z",
        "m.x.y",
        "m.ranges[7]",
        "m.name + 1",
        "len",
        "m.name.format(1)",
        "max(default=1)",
    ],
)
def test_refused_when_computed(text: str) -> None:
    """What does not fit the message, or would take for ever, is one clear error."""
    with pytest.raises(ExpressionError):
        Expression(text)(m=Point())


def test_work_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nested loops over arrays end."""
    monkeypatch.setattr(expression, "MAX_STEPS", 20_000)
    point = Point()
    point.ranges = [0.0] * 200
    loops = Expression("sum(1 for a in m.ranges for b in m.ranges for c in m.ranges)")
    with pytest.raises(ExpressionError, match="too many steps"):
        loops(m=point)


def test_an_error_names_the_fields_there_are() -> None:
    """A mistyped field is answered with the right ones."""
    with pytest.raises(ExpressionError, match="ranges, x, y") as caught:
        Expression("m.Y > 1")(m=Point())
    assert caught.value.text == "m.Y > 1"
