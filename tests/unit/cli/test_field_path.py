"""Field paths name parts of a message as `rostopic echo` does."""

from __future__ import annotations

import pytest

from rosproto.cli.fields import FieldPathError, parse_field_path, split_topic


class Leaf:
    __slots__ = ("x",)
    _type = "test/Leaf"

    def __init__(self, x: float) -> None:
        self.x = x


class Root:
    __slots__ = ("items", "leaf", "ranges")
    _type = "test/Root"

    def __init__(self) -> None:
        self.leaf, self.ranges, self.items = Leaf(2.0), (1, 2, 3, 4), [Leaf(5.0), Leaf(6.0)]


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("leaf/x", 2.0),
        ("/leaf/x", 2.0),
        ("ranges[0]", 1),
        ("ranges[-1]", 4),
        ("ranges[1:3]", (2, 3)),
        ("ranges[::2]", (1, 3)),
        ("items[1]/x", 6.0),
        ("items/x", [5.0, 6.0]),
        ("items[:1]/x", [5.0]),
    ],
)
def test_path(path: str, expected: object) -> None:
    """Fields, indices, slices, and fields of every element."""
    assert parse_field_path(path)(Root()) == expected


def test_the_empty_path_is_the_message() -> None:
    """A topic without a path means all of it."""
    root = Root()
    assert parse_field_path("")(root) is root


@pytest.mark.parametrize(
    "path", ["leaf//x", "1x", "ranges[", "ranges[]", "ranges[a]", "ranges[1.5]", "leaf.x"]
)
def test_malformed(path: str) -> None:
    """A malformed path is refused when typed."""
    with pytest.raises(FieldPathError):
        parse_field_path(path)


@pytest.mark.parametrize(
    ("path", "says"),
    [("y", "leaf"), ("leaf/y", "it has: x"), ("ranges[9]", "the length is 4"), ("leaf[0]", "not an array")],
)
def test_missing(path: str, says: str) -> None:
    """What the message lacks is answered with what it has."""
    with pytest.raises(FieldPathError, match=says):
        parse_field_path(path)(Root())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("/odom", ("/odom", "")),
        ("/odom/twist/x", ("/odom", "twist/x")),
        ("/odom/pose/x", ("/odom/pose", "x")),
        ("/odom/pose", ("/odom/pose", "")),
        ("/scan/ranges[0]", ("/scan", "ranges[0]")),
        ("/unknown/a", ("/unknown/a", "")),
    ],
)
def test_split_topic(text: str, expected: tuple[str, str]) -> None:
    """The longest known topic wins; what follows is the path."""
    assert split_topic(text, ["/odom", "/odom/pose", "/scan"]) == expected
