"""Bytes made to hurt are refused before memory is taken, with the place in the message."""

from __future__ import annotations

import gc
import time

import pytest

from rosproto.codec import decode, define, encode, message_class
from rosproto.codec.collector_pause import pause, resume
from rosproto.errors import CodecError, DefinitionError
from rosproto.msg import Field, FieldType, MessageSpec
from tests.support.memory import peak_of

MAX_COUNT = b"\xff\xff\xff\xff"
SEPARATOR = "\n" + "=" * 80 + "\nMSG: "


def refused(cls: type, data: bytes) -> CodecError:
    """Decode, expecting an error and little memory and little time of the processor."""
    with pytest.raises(
        CodecError
    ) as caught:  # also: generated once, so that the generator's memory is not counted
        decode(cls, data)  # type: ignore[type-var]

    def again() -> None:
        start = time.thread_time()
        with pytest.raises(CodecError):
            decode(cls, data)  # type: ignore[type-var]
        assert time.thread_time() - start < 2

    # Where there is no fork, what other threads of this process allocate is counted, too: that only adds.
    assert any(peak_of(again) < 200_000 + 100 * len(data) for _ in range(3))
    return caught.value


@pytest.mark.parametrize(
    "text",
    [
        "string x",
        "float64[] x",
        "uint8[] x",
        "bool[] x",
        "string[] x",
        "time[] x",
        "P[] x" + SEPARATOR + "a/P\nfloat64 v",
        "P[] x" + SEPARATOR + "a/P\nstring s\nint8 v",
        "P[] x" + SEPARATOR + "a/P\nuint8[] s",
        "P[] x" + SEPARATOR + "a/P\nQ[] q" + SEPARATOR + "a/Q\nstring v",
    ],
)
def test_a_length_bomb_is_refused(text: str) -> None:
    """4 GiB announced, a few bytes there: in each kind of field."""
    error = refused(define("a/B", text), MAX_COUNT + b"\0" * 100)
    assert error.field_path.startswith("x")
    assert error.offset in {0, 4}


@pytest.mark.promise("Four billion elements without bytes cost their sender")
@pytest.mark.parametrize("count", [MAX_COUNT, b"\xff\xff\0\0"])
def test_a_count_bomb_of_elements_without_bytes_is_refused(count: bytes) -> None:
    """2**32-1 std_msgs/Empty cost the sender nothing."""
    cls = define("a/B", "E[] x" + SEPARATOR + "a/E\n")
    assert refused(cls, count).field_path == "x"
    assert len(decode(cls, b"\3\0\0\0").x) == 3
    assert encode(decode(cls, b"\3\0\0\0")) == b"\3\0\0\0"


def test_nested_count_bombs_are_refused() -> None:
    """Many counts that are small each, and elements that hold much for one byte."""
    many = define("a/B", "C[] x" + SEPARATOR + "a/C\nE[] e" + SEPARATOR + "a/E\n")
    refused(many, b"\x00\x01\0\0" + b"\xff\xff\0\0" * 256)
    wide = define("a/B", "C[] x" + SEPARATOR + "a/C\nint8 v\nE[30000] e" + SEPARATOR + "a/E\n")
    refused(wide, b"\x00\x01\0\0" + b"\1" * 256)


def test_a_definition_with_endless_fixed_arrays_is_refused() -> None:
    """`T[4000000000]` would fill memory by construction alone; hand-made definitions are bounded too."""
    for field_type in (FieldType("uint8", True, 4_000_000_000), FieldType("string", True, 1_000_000)):
        cls = message_class(MessageSpec("a/Huge", (Field("x", field_type),), (), ""))
        with pytest.raises(DefinitionError, match="at most"):
            cls()


def test_deep_arrays_are_decoded() -> None:
    """Arrays in arrays, deeper than Python can nest loops in one function."""
    text = (
        "T1[] a"
        + "".join(f"{SEPARATOR}a/T{i}\nT{i + 1}[] a" for i in range(1, 12))
        + SEPARATOR
        + "a/T12\nint8 v"
    )
    cls = define("a/T0", text)
    data = b"\1\0\0\0" * 12 + b"\5"
    message = decode(cls, data)
    assert encode(message) == data
    refused(cls, b"\1\0\0\0" * 11 + MAX_COUNT)


def test_a_wide_definition_works() -> None:
    """Thousands of flattened fields are cut into several functions."""
    text = "\n".join(f"W w{i}\nW[] l{i}" for i in range(40)) + SEPARATOR + "a/W\n"
    text += "\n".join(f"float64 x{i}\nstring s{i}" for i in range(60))
    cls = define("a/B", text)
    message = cls()
    message.w39.s59 = "end"
    message.l39.append(message.w39)
    assert decode(cls, encode(message)).l39[0].s59 == "end"


@pytest.mark.promise("Text that is not UTF-8 comes back byte")
def test_text_that_is_not_utf_8_is_reversible() -> None:
    """Bytes become lone surrogates and the same bytes again; also beside arrays."""
    cls = define("a/B", "string s\nfloat32[] f\nstring[] many\nP[] p" + SEPARATOR + "a/P\nstring s")
    data = b"\2\0\0\0\xff\xfe" + b"\1\0\0\0\0\0\0\0" + b"\1\0\0\0\1\0\0\0\xc3" + b"\1\0\0\0\1\0\0\0\x80"
    message = decode(cls, data)
    assert message.s == "\udcff\udcfe"
    assert encode(message) == data
    assert not message.f.flags.writeable
    assert encode(cls(s=b"\xff\xfe", f=[0], many=[b"\xc3"], p=message.p)) == data


def test_the_collector_is_on_again_after_a_large_message() -> None:
    """It is paused while an array of many objects is built, also when that fails."""
    path = message_class("nav_msgs/Path")
    data = encode(path(poses=[message_class("geometry_msgs/PoseStamped")()] * 1000))
    assert gc.isenabled()
    decode(path, data)
    assert gc.isenabled()
    with pytest.raises(CodecError):
        decode(path, data[:-1])
    assert gc.isenabled()
    pause()
    pause()
    resume()
    assert not gc.isenabled()
    resume()
    assert gc.isenabled()
    gc.disable()
    try:
        decode(path, data)
        assert not gc.isenabled()
    finally:
        gc.enable()
