"""Guesses that make the codec fast are only guesses: wrong ones give the same values."""

from __future__ import annotations

from array import array
from collections import UserString

import pytest

from rosproto.codec import decode, decoder, define, encode, encode_parts, message_class
from rosproto.errors import CodecError

SEPARATOR = "\n" + "=" * 80 + "\nMSG: "


def test_two_messages_of_one_size_with_other_lengths() -> None:
    """Each is decoded by its own lengths."""
    cls = define("a/Guess", "string a\nfloat64[2] f\nstring b\nint8 c")
    for a, b in [("xx", "y"), ("xx", "y"), ("x", "yy"), ("", "yyy"), ("xxx", ""), ("xx", "y")]:
        message = cls(a=a, b=b, c=5, f=[1.0, 2.0])
        back = decode(cls, encode(message))
        assert back == message
        assert back.f.tolist() == [1.0, 2.0]


def test_fields_between_strings_and_arrays_around_them() -> None:
    """What lies between and around the strings of messages of one size."""
    text = "float64[2] f\nint16 i\nstring a\nbool b\ntime t\nstring c\nI n\nuint8 u\nfloat32[3] g"
    cls = define("a/Run", text + SEPARATOR + "a/I\nint64 x")
    inner = type(cls())._binding.class_for("a/I")  # type: ignore[union-attr]
    for step, (a, c) in enumerate([("x", "yy"), ("x", "yy"), ("x", "yy"), ("xx", "y"), ("z", "yy")]):
        message = cls(f=[1, step], i=step, a=a, b=step == 2, c=c, n=inner(x=-step), u=step, g=[step, 2, 3])
        message.t.secs, message.t.nsecs = step // 3, 7
        data = encode(message)
        for back in (decode(cls, data), decoder(cls)(b"??" + data + b"?", 2, len(data) + 2)):
            assert back == message
            assert (back.b, back.t.secs, back.f.tolist()) == (step == 2, step // 3, [1, step])
            assert back.g.tolist() == [step, 2, 3]
            assert back._connection_header is None


def test_arrays_of_more_lengths_than_are_remembered() -> None:
    """The structs of 64 lengths are kept; with the next one the table begins anew."""
    cls = define("a/Names", "I[] names" + SEPARATOR + "a/I\nint64 x\nstring name\nint8 y")
    inner = type(cls())._binding.class_for("a/I")  # type: ignore[union-attr]
    for length in [*range(70), *range(70)]:
        message = cls(names=[inner(x=number, name="n" * length, y=number) for number in range(8)])
        assert decode(cls, encode(message)) == message


def test_a_known_size_with_wrong_lengths_inside() -> None:
    """Lengths that do not add up are an error though the size is right."""
    cls = define("a/Sums", "string a\nstring b\nint32 x")
    good = cls(a="one", b="three", x=1)
    data = encode(good)
    for _ in range(3):
        assert decode(cls, data) == good
        for wrong in (b"\x04" + data[1:], b"\x02" + data[1:], b"\xff\xff\xff\xff" + data[4:]):
            with pytest.raises(CodecError):
                decode(cls, wrong)
        odd = data.replace(b"one", b"o\xffe")
        assert decode(cls, odd).a == "o\udcffe"
        assert encode(decode(cls, odd)) == odd


def test_text_that_changes_between_two_encodings() -> None:
    """The last strings are known by identity; what can change its text is asked again (and a str is its characters)."""
    cls = define("a/Texts", "string a\nint8 x\nstring b")

    class Label(UserString):
        pass

    class Loud(str):
        def encode(self, *args: str) -> bytes:  # type: ignore[override]
            return super().upper().encode(*args)

    label = Label("old")
    message = cls(a="one", b="two")
    message.a = label
    assert encode(message) == encode(message) == encode(cls(a="old", b="two"))
    label.data = "newer"
    assert encode(message) == encode(cls(a="newer", b="two"))
    message.a = Loud("loud")
    assert encode(message) == encode(message) == encode(cls(a="loud", b="two"))
    for a, b in [("one", "two"), ("one", "x" * 600), ("one", "x" * 600), ("one", "two"), ("", "")]:
        message.a, message.b = a, b
        assert decode(cls, encode(message)) == message
    message.a = None
    for _ in range(2):
        with pytest.raises(CodecError, match=r"a/Texts.a: str expected"):
            encode(message)
    fresh = define("a/Fresh", "string a\nint8 x")()
    fresh.a = None
    with pytest.raises(CodecError, match=r"a/Fresh.a: str expected"):
        encode(fresh)


@pytest.mark.parametrize(
    "fields",
    [
        "Header header\nfloat64 x\nfloat64 y",
        "int8 i\nstring s\nfloat64 x",
        "time t\nstring s\nduration d",
        "string s\nfloat64 x\nint16 i",
        "N n\nfloat64 x",
        "string s\nfloat64 x\nfloat32 y",
        "float64 x\nstring s",
    ],
)
def test_long_arrays_of_every_alignment(fields: str) -> None:
    """Long arrays are packed from the middle of one element to the middle of the next where that pays."""
    nested = "a/N\nstring s\nfloat64 z"
    header = "std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id"
    cls = define(
        "a/Long", "P[] p\nint8 end" + "".join(SEPARATOR + t for t in ("a/P\n" + fields, nested, header))
    )
    element = type(cls())._binding.class_for("a/P")  # type: ignore[union-attr]
    message = cls(p=[element() for _ in range(40)], end=3)
    for index, item in enumerate(message.p):
        for name in item.__slots__:
            if name in ("x", "y"):
                setattr(item, name, index / 4)
    expected = b"\x28\0\0\0" + b"".join(map(encode, message.p)) + b"\x03"
    assert encode(message) == expected
    assert decode(cls, expected) == message


def test_buffers_of_one_message() -> None:
    """decode() takes any buffer whose bytes are the message, and copies what is not bytes."""
    scan = message_class("sensor_msgs/LaserScan")
    for cls, message in (
        (message_class("std_msgs/Float64"), message_class("std_msgs/Float64")(data=2.5)),
        (message_class("std_msgs/String"), message_class("std_msgs/String")(data="text of 12 ch")),
        (scan, scan(ranges=[1.0, 2.0])),
    ):
        data = encode(message)
        own = bytearray(data)
        for buffer in (data, own, memoryview(own), memoryview(own)[::1], array("B", data)):
            assert decode(cls, buffer) == message
        back = decode(cls, own)
        own[:] = bytes(len(own))
        assert back == message
        for wrong in (5, None, "text", [1, 2, 3], memoryview(bytes(2 * len(data)))[::2].tolist()):
            with pytest.raises(TypeError):
                decode(cls, wrong)  # type: ignore[arg-type]
        for end in range(len(data)):
            with pytest.raises(CodecError):
                decode(cls, bytearray(data[:end]))
        with pytest.raises(CodecError):
            decode(cls, data + b"!")
    with pytest.raises(CodecError):
        decode(message_class("std_msgs/Float64"), array("d", [1.0] * 8))  # 8 elements, but 64 bytes


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
    """A string is encoded again only if it is another object; a wrong value is named by its index."""
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


@pytest.mark.parametrize("count", [*range(10), 31, 32, 33, 35, 36, 70])
def test_small_elements_four_by_four(count: int) -> None:
    """Any number of them, from lists and tuples; a wrong one is named by its index."""
    polygon, point = message_class("geometry_msgs/Polygon"), message_class("geometry_msgs/Point32")
    points = [point(x=i, y=i / 2, z=-i) for i in range(count)]
    expected = bytes([count, 0, 0, 0]) + b"".join(map(encode, points))
    for given in (points, tuple(points)):
        message = polygon(points=given)
        assert encode(message) == expected
        assert b"".join(encode_parts(message)) == expected
        assert message.points is given
    assert decode(polygon, expected) == polygon(points=points)
    for index in range(count):
        points[index].y = "high"
        with pytest.raises(CodecError, match=rf"Polygon\.points\[{index}\]\.y: float32 expected"):
            encode(polygon(points=points))
        points[index].y = 0.0
