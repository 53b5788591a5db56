"""Guesses that make the codec fast are only guesses: wrong ones give the same values."""

from __future__ import annotations

import pytest

from rosproto.codec import decode, define, encode, message_class
from rosproto.errors import CodecError

SEPARATOR = "\n" + "=" * 80 + "\nMSG: "


def test_two_messages_of_one_size_with_other_lengths() -> None:
    """The decoder remembers the string lengths of the last message of a size."""
    cls = define("a/Guess", "string a\nfloat64[2] f\nstring b\nint8 c")
    for a, b in [("xx", "y"), ("xx", "y"), ("x", "yy"), ("", "yyy"), ("xxx", ""), ("xx", "y")]:
        message = cls(a=a, b=b, c=5, f=[1.0, 2.0])
        back = decode(cls, encode(message))
        assert back == message
        assert back.f.tolist() == [1.0, 2.0]


def test_lengths_that_never_repeat() -> None:
    """The memory is bounded; afterwards everything still works."""
    cls = define("a/Never", "string a\nstring b")
    for index in range(5000):
        message = cls(a="x" * (index % 700), b="y" * (index % 71))
        assert decode(cls, encode(message)) == message


def test_elements_of_other_lengths_than_the_first() -> None:
    """Arrays are read as if all strings were as long as the first element's."""
    cls = define("a/Probe", "int8 x\nP[] p\nint8 y" + SEPARATOR + "a/P\nstring s\ntime t\nstring u")
    p = type(cls())._binding.class_for("a/P")  # type: ignore[union-attr]
    for texts in (
        ["a"] * 6,
        ["a", "a", "bb", "a", "a"],
        ["", "a", "b", "c"],
        ["a", "b", "c", ""],
        ["é", "e", "éé"],
    ):
        message = cls(x=1, p=[p(s=text, u=text[:1]) for text in texts], y=2)
        assert decode(cls, encode(message)) == message
        assert [item.s for item in decode(cls, encode(message)).p] == texts


def test_long_arrays_with_one_string_and_with_many() -> None:
    """The comprehension for equal strings gives up at the first other one, and the loop does the work."""
    path, pose = message_class("nav_msgs/Path"), message_class("geometry_msgs/PoseStamped")
    message = path(poses=[pose() for _ in range(100)])
    for index, item in enumerate(message.poses):
        item.header.seq, item.header.frame_id, item.pose.position.x = index, "map", index / 2
    assert decode(path, encode(message)) == message
    message.poses[99].header.frame_id = "odometry"
    assert decode(path, encode(message)) == message
    message.poses[50].pose.position.x = "far"
    with pytest.raises(CodecError, match=r"poses\[50\].pose.position.x: float64 expected"):
        encode(message)
    hollow = define(
        "a/H",
        "P[] p" + SEPARATOR + "a/P\nE e\nQ q\nint8 x" + SEPARATOR + "a/E\n" + SEPARATOR + "a/Q\nE e\nint8 y",
    )
    element = type(hollow())._binding.class_for("a/P")  # type: ignore[union-attr]
    assert decode(hollow, encode(hollow(p=[element(x=i) for i in range(50)]))).p[49].x == 49


def test_a_message_is_encoded_as_it_is_now() -> None:
    """Structs are chosen by lengths, and strings of neighbours are shared; changes are seen."""
    cls = define("a/Now", "P[] p" + SEPARATOR + "a/P\nstring s\nint8 x")
    p = type(cls())._binding.class_for("a/P")  # type: ignore[union-attr]
    message = cls(p=[p(s="one", x=i) for i in range(4)])
    first = encode(message)
    message.p[2].s = "two"
    message.p[3].s = "three"
    assert encode(message) == first.replace(b"one\x02", b"two\x02").replace(
        b"\3\0\0\0one\x03", b"\5\0\0\0three\x03"
    )
