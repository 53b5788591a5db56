"""genpy's face: construction, equality, text, copies, pickles, errors of single fields."""

from __future__ import annotations

import copy
import io
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rosproto.codec import AnyMsg, ValueStyle, decode, define, encode, encode_parts, message_class
from rosproto.codec.binding import Binding
from rosproto.codec.encode_decode import decoder, encoder, prepare
from rosproto.codec.layout import FORMATS, RANGES_BY_CODE
from rosproto.errors import CodecError, DefinitionError
from rosproto.time import Duration, Time

Twist = message_class("geometry_msgs/Twist")
Vector3 = message_class("geometry_msgs/Vector3")
Odometry = message_class("nav_msgs/Odometry")
Header = message_class("std_msgs/Header")


def test_the_functions_behind_encode_and_decode_do_the_same() -> None:
    """For frequent calls; also before the class was used, and for bytes of any type."""
    kind = define("test_msgs/Own", "int32 number\nstring text\n")
    data = encoder(kind)(kind(number=7, text="a"))
    assert data == encode(kind(number=7, text="a"))
    assert decoder(kind)(b"-" + data, 1, 1 + len(data)) == kind(number=7, text="a")
    assert encoder(AnyMsg)(decode(AnyMsg, data)) == data


def test_construction_is_positional_or_by_keyword() -> None:
    """All fields by position, any by keyword; None asks for the default."""
    assert Vector3(1.0, 2.0, 3.0) == Vector3(x=1.0, y=2.0, z=3.0)
    assert Twist(None, Vector3(1, 2, 3)).linear == Vector3()
    assert Twist(linear=None).linear == Vector3()
    with pytest.raises(TypeError, match="2 arguments given, expected all of geometry_msgs/Vector3"):
        Vector3(1.0, 2.0)
    with pytest.raises(TypeError, match="not both"):
        Vector3(1.0, 2.0, z=3.0)
    with pytest.raises(
        AttributeError, match="'w' is not a field of geometry_msgs/Vector3, which has x, y, z"
    ):
        Vector3(w=1.0)


def test_unknown_attributes_are_refused() -> None:
    """A misspelt field is an error, not a silent attribute."""
    with pytest.raises(AttributeError):
        Twist().liner = Vector3()  # type: ignore[attr-defined]
    with pytest.raises(AttributeError):
        _ = Twist().liner  # type: ignore[attr-defined]


def test_serialize_and_deserialize() -> None:
    """As genpy: into a buffer with write(), and from bytes in place; the message is returned."""
    buffer = io.BytesIO()
    Vector3(1, 2, 3).serialize(buffer)
    message = Vector3()
    assert message.deserialize(buffer.getvalue()) is message
    assert message == Vector3(1, 2, 3)
    with pytest.raises(CodecError):
        message.deserialize(b"")
    assert message == Vector3(1, 2, 3)


def test_equality_goes_by_value() -> None:
    """Arrays, lists and tuples are equal by element; NaN is not equal to itself; types matter."""
    first, second = Odometry(), Odometry()
    assert first == second
    second.pose.covariance = [0.0] * 36
    assert first == second
    second.pose.covariance = [0.0] * 35 + [1.0]
    assert first != second
    nan = Vector3(x=float("nan"))
    assert nan != Vector3(x=float("nan"))
    assert Vector3() != message_class("geometry_msgs/Point")()
    assert Vector3() != 5
    with pytest.raises(TypeError, match="unhashable"):
        hash(Vector3())


def test_the_text_is_indented_name_value() -> None:
    """The form of genpy.message.strify_message."""
    assert str(Vector3(1.0, -0.0, 3.5)) == "x: 1.0\ny: -0.0\nz: 3.5"
    assert str(Header(seq=1, stamp=Time(2, 3), frame_id='a"b')) == (
        'seq: 1\nstamp: \n  secs: 2\n  nsecs:         3\nframe_id: "a\\"b"'
    )
    assert repr(Header(frame_id="")).endswith("frame_id: ''")
    scan = message_class("sensor_msgs/LaserScan")(ranges=[0.5, 1.0])
    assert "ranges: [0.5, 1.0]" in str(scan)
    assert "ranges: [0.5, 1.0]" in str(decode(type(scan), encode(scan)))


def test_copies() -> None:
    """copy shares the values, deepcopy does not, and makes arrays writable."""
    message = decode(Odometry, encode(Odometry(child_frame_id="x")))
    message._connection_header = {"callerid": "/a"}
    shallow, deep = copy.copy(message), copy.deepcopy(message)
    assert shallow == deep == message
    assert shallow.pose is message.pose
    assert deep.pose is not message.pose
    deep.pose.covariance[0] = 1.0
    assert message.pose.covariance[0] == 0.0
    assert shallow._connection_header == {"callerid": "/a"}


def test_pickles_here_and_in_another_process() -> None:
    """Bundled classes are found by name, classes of define() travel with their text."""
    defined = define("a/B", "Q q\nfloat32[] f\n" + "=" * 80 + "\nMSG: a/Q\ntime t")
    message = defined(f=[1.0, 2.0])
    message.q.t.secs, message.q.t.nsecs = 5, 2_000_000_000
    back = pickle.loads(pickle.dumps([Twist(linear=Vector3(x=1.0)), message]))
    assert back == [Twist(linear=Vector3(x=1.0)), message]
    assert type(back[1]) is defined
    program = (
        "import pickle, sys; a, b = pickle.loads(sys.stdin.buffer.read());"
        "print(a.linear.x, b.q.t.nsecs, list(b.f), type(b)._type)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        input=pickle.dumps([Twist(linear=Vector3(x=1.0)), message]),
        capture_output=True,
        timeout=60,
        check=True,
        cwd=Path(__file__).resolve().parents[3],
    )
    assert done.stdout.decode().splitlines()[0] == "1.0 2000000000 [1.0, 2.0] a/B"


def test_a_pickle_of_another_definition_is_refused() -> None:
    """Rather than filling the wrong fields."""
    restore, found, _ = Twist().__reduce__()
    with pytest.raises(DefinitionError, match="was pickled with md5sum 0000"):
        restore(found[0], "0000", *found[2:])


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (Vector3(x="1"), r"geometry_msgs/Vector3.x: float64 expected, not str '1'"),
        (Twist(linear=5), r"geometry_msgs/Twist.linear: a geometry_msgs/Vector3 is expected, not int 5"),
        (Twist(linear={"x": 1}), r"geometry_msgs/Twist.linear: a geometry_msgs/Vector3 is expected"),
        (Header(seq=-1), r"std_msgs/Header.seq: -1 is out of range for uint32 \(0..4294967295\)"),
        (Header(seq=1.5), r"std_msgs/Header.seq: uint32 expected \(0..4294967295\), not float 1.5"),
        (Header(stamp=1.5), r"std_msgs/Header.stamp: a Time is expected, not float 1.5; Time.from_sec"),
        (Header(frame_id=5), r"std_msgs/Header.frame_id: str expected, not int 5"),
        (Header(frame_id="\ud800"), r"std_msgs/Header.frame_id: surrogates not allowed"),
        (message_class("std_msgs/Float32")(data=1e39), r"float 1e\+39 is out of range for float32"),
        (
            message_class("std_msgs/Bool")(data="false"),
            r"std_msgs/Bool.data: bool expected \(True or False\)",
        ),
        (message_class("std_msgs/Int8")(data=200), r"200 is out of range for int8 \(-128..127\)"),
        (message_class("nav_msgs/Path")(poses=5), r"nav_msgs/Path.poses: a sequence is expected"),
        (
            message_class("nav_msgs/Path")(poses=[Vector3()]),
            r"nav_msgs/Path.poses\[0\]: a geometry_msgs/PoseStamped",
        ),
        (define("a/S", "string[] s")(s="text"), r"a/S.s: a sequence is expected for string\[\], not str"),
        (define("a/T", "time[2] t")(t=[Time()]), r"a/T.t: 2 elements expected, not 1"),
        (define("a/T", "duration[] t")(t=[1]), r"a/T.t\[0\]: a Duration is expected, not int 1"),
    ],
)
def test_a_wrong_value_is_named(message: Any, words: str) -> None:
    """Type, path, value and range; what was expected and what to do."""
    with pytest.raises(CodecError, match=words):
        encode(message)


@pytest.mark.parametrize("code", sorted(RANGES_BY_CODE))
def test_every_integer_range_is_watched(code: str) -> None:
    """Alone, in a run of equal fields, and in an array: struct itself refuses, the message has the range."""
    name = next(name for name, known in FORMATS.items() if known == code)
    low, high = RANGES_BY_CODE[code]
    cls = define("a/I", f"{name} x\n{name} y\n{name}[] many\nE[] e\n{'=' * 80}\nMSG: a/E\n{name} v")
    element = type(cls())._binding.class_for("a/E")  # type: ignore[union-attr]
    if code != "?":
        good = cls(x=low, y=high, many=[low, high], e=[element(v=high)])
        assert decode(cls, encode(good)) == good
    for value in (low - 1, high + 1, 1 << 70):
        for wrong in (cls(x=value), cls(many=[value]), cls(e=[element(v=value)])):
            with pytest.raises(CodecError, match=f"{value} is out of range for {name}"):
                encode(wrong)


def test_numpy_scalars_and_odd_truths_are_values() -> None:
    """What arithmetic with arrays gives can be assigned."""
    np = pytest.importorskip("numpy")
    assert encode(message_class("std_msgs/Bool")(data=np.bool_(True))) == b"\1"
    assert encode(message_class("std_msgs/Int8")(data=np.int64(5))) == b"\5"
    assert encode(message_class("std_msgs/Float32")(data=np.float32(0.5))) == b"\0\0\0?"


def test_a_value_style_brings_its_own_errors_and_times() -> None:
    """The seam for the rospy layer."""

    class StampError(Exception):
        pass

    class Stamp(Time):
        pass

    value_style = ValueStyle("test", views=False, time=Stamp, encode_error=lambda e: StampError(str(e)))
    header = message_class("std_msgs/Header", value_style=value_style)
    assert type(header().stamp) is Stamp
    assert type(decode(header, encode(Header())).stamp) is Stamp
    with pytest.raises(StampError, match="seq"):
        encode(header(seq=-1))


def test_raw_wire_times_are_kept() -> None:
    """Seconds overflow in nsecs survives a relay."""
    data = b"\1\0\0\0\2\0\0\0\xff\xff\xff\xff\0\0\0\0"
    message = decode(Header, data)
    assert (message.stamp.secs, message.stamp.nsecs) == (2, 0xFFFFFFFF)
    assert encode(message) == data
    durations = define("a/D", "duration d\nduration[] many")
    data = b"\xff\xff\xff\xff\0\0\0\x80" * 1 + b"\1\0\0\0" + b"\0\0\0\x80\xff\xff\xff\xff"
    assert decode(durations, data).many[0] == Duration.from_wire(-(1 << 31), -1)
    assert encode(decode(durations, data)) == data


def test_definitions_with_comments_that_are_not_utf8() -> None:
    """Such texts exist (vendors write Latin-1 or GBK comments); nested types have them too."""
    text = b"Other o\n" + b"=" * 80 + b"\nMSG: my_msgs/Other\nint32 a # caf\xe9\n"
    cls = define("my_msgs/Outer", text.decode("utf-8", "surrogateescape"))
    assert decode(cls, encode(cls())).o.a == 0
    assert "caf\\udce9" in (type(cls().o).__doc__ or "")


@pytest.mark.parametrize("parts", [False, True])
def test_nothing_is_generated_for_the_first_message_of_a_prepared_class(
    parts: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A class without generated functions is ready as it is."""
    cls = define("a/Prepared", "float64 x")
    prepare(cls, parts=parts)
    prepare(AnyMsg, parts=parts)

    def made(_: Binding, name: str) -> None:
        raise AssertionError(f"{name} is generated with the first message")

    monkeypatch.setattr(Binding, "_make", made)
    message = cls(x=1.0)
    assert b"".join(encode_parts(message) if parts else [encode(message)]) == bytes(6) + b"\xf0\x3f"
