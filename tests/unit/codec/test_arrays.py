"""Arrays of numbers: views when decoded, and everything that may be assigned."""

from __future__ import annotations

import array
from typing import Any

import numpy as np
import pytest

from rosproto.codec import decode, decoder, define, encode, encode_parts, message_class
from rosproto.errors import CodecError

NUMBERS = define("a/Numbers", "float32[] f\nuint8[] u\nbool[] b\nfloat64[3] d\nint16[] s\nchar[2] c")


def test_decoded_arrays_are_read_only_views_of_the_bytes() -> None:
    """No copy is made, nobody can change what others see, and `copy()` gives a writable array."""
    data = encode(NUMBERS(f=np.arange(4, dtype="f4"), u=b"abc"))
    message = decode(NUMBERS, data)
    assert message.f.dtype == np.float32
    assert np.shares_memory(message.f, np.frombuffer(data, "u1"))
    for value in (message.f, message.u, message.b, message.d):
        assert not value.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        message.f[0] = 1
    copied = message.f.copy()
    copied[0] = 9
    assert list(message.f) == [0, 1, 2, 3]


def test_mutable_buffers_are_copied_by_decode_and_owned_by_decoder() -> None:
    """decode() is safe with a buffer that is used again; decoder() trusts its caller."""
    buffer = bytearray(encode(NUMBERS(u=b"abc")))
    safe = decode(NUMBERS, buffer)
    owned = decoder(NUMBERS)(buffer, 0, len(buffer))
    buffer[buffer.index(b"abc")] = ord("z")
    assert bytes(safe.u) == b"abc"
    assert bytes(owned.u) == b"zbc"
    assert not owned.u.flags.writeable
    assert NUMBERS._has_views
    assert not message_class("geometry_msgs/Twist")._has_views


@pytest.mark.promise("rospy has `uint8[]` as bytes")
def test_any_non_zero_byte_is_true() -> None:
    """goroslib takes only 1 for true; ROS does not say so."""
    cls = define("a/Bools", "bool one\nbool[] many\nbool[3] fixed")
    message = decode(cls, b"\x07" + b"\x02\0\0\0\x00\xff" + b"\x01\x80\x00")
    assert message.one is True
    assert message.many.tolist() == [False, True]
    assert message.fixed.tolist() == [True, True, False]
    assert encode(message) == b"\x01" + b"\x02\0\0\0\x00\x01" + b"\x01\x01\x00"


@pytest.mark.parametrize(
    "value",
    [
        [1, 2, 3],
        (1, 2, 3),
        range(1, 4),
        array.array("h", [1, 2, 3]),
        np.array([1, 2, 3]),
        np.array([1.0, 2.0, 3.0]),
        np.array([1, 2, 3], ">i4"),
        np.array([1, 9, 2, 9, 3, 9], "f4")[::2],
        np.array([[1], [2], [3]], "f4"),
        iter([1, 2, 3]),
    ],
    ids=lambda v: type(v).__name__,
)
def test_what_holds_numbers_can_be_assigned(value: Any) -> None:
    """Lists, tuples, other dtypes, strided and big-endian arrays all become the same bytes."""
    cls = define("a/F", "string before\nfloat32[] f")
    assert encode(cls(f=value)) == b"\0\0\0\0" + np.array([1, 2, 3], "<f4").tobytes().join([b"\3\0\0\0", b""])


@pytest.mark.parametrize(
    "value", [b"abc", bytearray(b"abc"), memoryview(b"abc"), [97, 98, 99], np.frombuffer(b"abc", "u1")]
)
def test_octets_can_be_bytes(value: Any) -> None:
    """uint8[] and char[], of fixed and of any length."""
    cls = define("a/U", "uint8[] u\nchar[3] c")
    assert encode(cls(u=value, c=value)) == b"\3\0\0\0abcabc"


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("u", [1, 300], r"u\[1\]: 300 is out of range for uint8 \(0..255\)"),
        ("u", [-1], r"u\[0\]: -1 is out of range"),
        ("u", np.array([1, 300]), r"u\[1\]: 300 is out of range"),
        ("u", np.array([0.5]), r"u\[0\]: uint8 expected \(0..255\), not float 0.5"),
        ("u", "text", r"u: a sequence is expected for uint8\[\], not str 'text'"),
        ("u", 5, r"u: a sequence is expected for uint8\[\], not int 5"),
        ("u", None, r"u: a sequence is expected"),
        ("u", np.uint8(3), r"u: a sequence is expected"),
        ("f", b"abcd", r"f: a sequence is expected for float32\[\], not bytes"),
        ("f", [1.0, "x"], r"f\[1\]: float32 expected, not str 'x'"),
        ("f", [1e300], r"f\[0\]: float 1e\+300 is out of range for float32"),
        ("f", np.array([1e300]), r"f\[0\]: float 1e\+300 is out of range for float32"),
        ("d", [1.0, 2.0], r"d: 3 elements expected, not 2"),
        ("d", np.zeros(4), r"d: 3 elements expected, not 4"),
        ("c", b"abc", r"c: 2 elements expected, not 3"),
        ("b", ["false"], r"b\[0\]: bool expected \(True or False\), not str 'false'"),
        ("s", [1 << 15], r"s\[0\]: 32768 is out of range for int16 \(-32768..32767\)"),
    ],
)
def test_a_wrong_element_is_named_with_its_range(field: str, value: Any, words: str) -> None:
    """Type, path with index, value and range are in the text; type and path are attributes."""
    with pytest.raises(CodecError, match=r"^a/Numbers\." + words) as caught:
        encode(NUMBERS(**{field: value}) if value is not None else _with(field, None))
    assert caught.value.type_name == "a/Numbers"
    assert caught.value.field_path.startswith(field)


def _with(field: str, value: Any) -> Any:
    message = NUMBERS()
    setattr(message, field, value)
    return message


@pytest.mark.promise("NaN, -0.0 and denormals come back bit for")
def test_special_floats_survive_bit_for_bit() -> None:
    """NaN payloads, negative zero, denormals."""
    cls = define("a/D", "float64 x\nfloat64[] many\nfloat32[] single")
    doubles = bytes.fromhex("010000000000f07f00000000000000800100000000000000efbeaddeadfbff7f")
    singles = bytes.fromhex("0100807f010000000000008001234567")
    data = doubles[-8:] + b"\4\0\0\0" + doubles + b"\4\0\0\0" + singles
    assert encode(decode(cls, data)) == data


def test_default_arrays_are_writable() -> None:
    """`msg.pose.covariance[0] = 0.1` works on a new message; arrays of messages are lists."""
    odometry = message_class("nav_msgs/Odometry")()
    odometry.pose.covariance[0] = 0.1
    assert odometry.pose.covariance.shape == (36,)
    scan = message_class("sensor_msgs/LaserScan")()
    assert (scan.ranges.dtype, len(scan.ranges)) == (np.float32, 0)
    path = message_class("nav_msgs/Path")()
    path.poses.append(message_class("geometry_msgs/PoseStamped")())
    assert path.poses is not message_class("nav_msgs/Path")().poses


def test_large_arrays_are_handed_out_uncopied() -> None:
    """encode_parts gives the caller's own memory; small parts are joined."""
    pixels = np.zeros((480, 640, 3), "u1")
    image = message_class("sensor_msgs/Image")(data=pixels, encoding="rgb8")
    parts = encode_parts(image)
    assert len(parts) == 2
    assert parts[1].nbytes == pixels.size  # type: ignore[union-attr]
    assert np.shares_memory(np.frombuffer(parts[1], "u1"), pixels)
    assert b"".join(parts) == encode(image)


@pytest.mark.parametrize("padding", range(9))
def test_parts_of_received_and_strided_arrays(padding: int) -> None:
    """A relay hands on arrays that lie unaligned in what it received; a crop is not contiguous."""
    cls = define("a/Relay", "string s\nfloat32[] f\nbool[] b\nfloat64[] d\nuint8[] u")
    ramp = np.arange(5000)
    message = cls(s="x" * padding, f=ramp.astype("f4"), b=ramp % 2 == 0, d=ramp * 0.5, u=bytearray(5000))
    received = decode(cls, encode(message))
    assert b"".join(encode_parts(received)) == encode(message) == b"".join(encode_parts(message))
    assert len(encode_parts(received)) >= 5
    message.f, message.d = ramp.repeat(2).astype("f4")[::2], np.asfortranarray((ramp * 0.5).reshape(50, 100))
    assert b"".join(encode_parts(message)) == encode(received) == encode(message)
    message.u = memoryview(bytes(10000))[::2]
    assert b"".join(encode_parts(message)) == encode(received) == encode(message)


@pytest.mark.promise("rospy has `uint8[]` as bytes")
def test_the_rospy_value_style_has_genpys_values() -> None:
    """Tuples, bytes for octets, lists by default."""
    cls = message_class("a/Numbers", NUMBERS._binding.library, value_style="rospy")  # type: ignore[union-attr]
    assert (cls().f, cls().u, cls().d, cls().c) == ([], b"", [0.0, 0.0, 0.0], b"\0\0")
    message = decode(cls, encode(NUMBERS(f=[1], u=[1, 2], b=[True], s=[5])))
    assert (message.f, message.u, message.s, message.c) == ((1.0,), b"\1\2", (5,), b"\0\0")
    assert message.b == [True]
    assert not cls._has_views


def test_empty_fixed_arrays_take_no_bytes() -> None:
    """`T[0]` is legal and useless."""
    cls = define("a/Zero", "float32[0] f\nuint8[0] u\nstring[0] s")
    assert encode(cls()) == b""
    assert decode(cls, b"").f.size == 0
