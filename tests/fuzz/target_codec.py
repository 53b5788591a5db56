"""Fuzz targets of rosproto.msg and rosproto.codec: definition texts, full texts from peers, message bytes."""

from __future__ import annotations

from collections.abc import Callable

from rosproto.codec import decode, define, encode, message_class
from rosproto.codec.layout import resolve
from rosproto.codec.reference import decode_layout
from rosproto.errors import CodecError, DefinitionError
from rosproto.msg import bundled, parse_action, parse_message, parse_service

TYPES = [
    "std_msgs/Empty",
    "std_msgs/String",
    "std_msgs/Bool",
    "std_msgs/Time",
    "geometry_msgs/Twist",
    "geometry_msgs/Polygon",
    "nav_msgs/Odometry",
    "nav_msgs/Path",
    "sensor_msgs/LaserScan",
    "sensor_msgs/Image",
    "sensor_msgs/PointCloud2",
    "sensor_msgs/JointState",
    "tf2_msgs/TFMessage",
    "diagnostic_msgs/DiagnosticArray",
    "std_msgs/Float64MultiArray",
    "visualization_msgs/InteractiveMarkerUpdate",
    "woosh_msgs/RobotStatus",
    "woosh_msgs/StepControlActionGoal",
]
CLASSES = [message_class(name) for name in TYPES]


def definition(data: bytes) -> str:
    """A text is refused with file and line, or is a definition that reads the same a second time."""
    text = data.decode("utf-8", "surrogateescape")
    kinds = []
    for parse in (parse_message, parse_service, parse_action):
        try:
            spec = parse(text, "fuzz_msgs/Thing", file="thing")
            assert parse(spec.text, "fuzz_msgs/Thing", file="thing") == spec
            kinds.append("read")
        except DefinitionError as error:
            kinds.append(f"{error.file}: {str(error).partition(':')[2][:40]}")
    assert "None" not in "".join(kind.partition(":")[0] for kind in kinds), "an error without its file"
    return "; ".join(kinds)


def full_text(data: bytes) -> str:
    """What a peer sends as its definition becomes a class that encodes its defaults, or an error."""
    try:
        cls = define("fuzz_msgs/Thing", data.decode("utf-8", "surrogateescape"))
        encoded = encode(cls())
    except (DefinitionError, CodecError) as error:
        return str(error)[:60]
    assert encode(decode(cls, encoded)) == encoded
    return f"{len(cls.__slots__)} fields"


def message(data: bytes) -> str:
    """The generated code and the reference codec agree on any bytes: the same value, or both refuse."""
    cls = CLASSES[data[0] % len(CLASSES)] if data else CLASSES[0]
    body = bytes(data[1:])
    try:
        decoded = decode(cls, body)
    except CodecError as error:
        try:
            decode_layout(resolve(cls._spec, bundled()), body, 0, len(body))
        except CodecError:
            return f"{cls._type}: {str(error)[:40]}"
        raise AssertionError("the reference codec takes what the generated code refuses") from error
    decode_layout(resolve(cls._spec, bundled()), body, 0, len(body))
    again = encode(decoded)
    # A bool of 7 is true, and true is written as 1: the one thing that does not come back as it was.
    assert len(again) == len(body)
    assert encode(decode(cls, again)) == again
    return cls._type


TARGETS: dict[str, Callable[[bytes], str]] = {
    "definition": definition,
    "full_text": full_text,
    "message": message,
}
_WORDS = [
    *(f"{name} ".encode() for name in "bool int8 uint8 byte char int64 float32 string time duration".split()),
    b"Header header\n", b"[]", b"[3]", b"[0]", b"[4294967295]", b" x\n", b"=", b"#", b"---\n", b"std_msgs/Header ",
    b"=" * 80 + b"\n", b"MSG: fuzz_msgs/Thing\n", b"MSG: std_msgs/Header\n", b"Thing ", b"fuzz_msgs/Thing[] ", b"\r\n",
]  # fmt: skip
TOKENS = {
    "definition": _WORDS,
    "full_text": _WORDS,
    "message": [b"\xff\xff\xff\xff", b"\0\0\0\0", b"\1\0\0\0", b"\2\0\0\0x\xff", b"\0" * 48],
}
