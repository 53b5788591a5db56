"""Values as people and programs write them: into messages, calls and replies, and messages as text."""

from __future__ import annotations

import random
import tempfile
import time
from pathlib import Path
from typing import Any

from rosproto import BagWriter, message_class
from rosproto.cli.yaml_values import fields_of
from rosproto.codec import Message, encode, service_class
from rosproto.codec.dicts import from_dict
from rosproto.errors import RosError
from rosproto.node import Node
from rosproto.time import Time
from tests.interop.compare import yaml_texts
from tests.interop.compare.comparison import Answer, Case, Kind, Peer, environment, run_command

TYPES = [
    "std_msgs/String", "std_msgs/Bool", "std_msgs/Int8", "std_msgs/UInt8", "std_msgs/Int64", "std_msgs/UInt64", "std_msgs/Float32",
    "std_msgs/Time", "std_msgs/Duration", "std_msgs/Header", "std_msgs/ColorRGBA", "std_msgs/Float64MultiArray",
    "std_msgs/UInt8MultiArray", "std_msgs/Empty", "std_msgs/Char", "geometry_msgs/Twist", "geometry_msgs/PoseStamped",
    "geometry_msgs/Polygon", "geometry_msgs/PoseArray", "sensor_msgs/Joy", "sensor_msgs/JointState", "sensor_msgs/Range",
    "sensor_msgs/CompressedImage", "diagnostic_msgs/DiagnosticArray", "actionlib_msgs/GoalStatusArray", "nav_msgs/GridCells",
]  # fmt: skip
FITTING = {
    "bool": ["true", "false", "1", "0", "True"], "string": ["a", "'a b'", "", "'5'", "map", "\u4e2d", "'it''s'", "\"a\\tb\"", "a  b"],
    "time": ["now", "{secs: 1, nsecs: 2}", "[3, 4]", "5", "0", "1500000000123456789", "{secs: 7}", "{}"],
    "duration": ["{secs: -1, nsecs: 2}", "[3, 4]", "-5", "{nsecs: 9}", "2000000001"],
    "std_msgs/Header": ["auto", "{frame_id: map}", "{stamp: now, frame_id: x}", "[1, now, m]", "{seq: 5}"],
}  # fmt: skip
NUMBERS = [
    "0",
    "1",
    "-1",
    "127",
    "255",
    "256",
    "-129",
    "65536",
    "2147483648",
    "4294967296",
    "9223372036854775808",
]


def fitting(chance: random.Random, kind: str, depth: int = 0) -> str:
    """A text that mostly fits a field."""
    if chance.random() < 0.06:
        return yaml_texts.flow(chance, 1)
    base, bracket, rest = kind.partition("[")
    if bracket:
        count = chance.randrange(4) if rest == "]" or chance.random() < 0.2 else int(rest[:-1])
        return "[" + ", ".join(fitting(chance, base, depth + 1) for _ in range(count)) + "]"
    if base in FITTING:
        return chance.choice(FITTING[base])
    if base.startswith("float"):
        return chance.choice(["0.0", "1", "-1.5", "1.0e-5", ".inf", "123456789.0"])
    if "/" not in base:
        return chance.choice(NUMBERS[:4] if chance.random() < 0.7 else NUMBERS)
    cls: Any = message_class(base)
    names = list(zip(cls.__slots__, cls._slot_types, strict=True))
    if chance.random() < 0.3:
        return "[" + ", ".join(fitting(chance, k, depth + 1) for _, k in names) + "]"
    some = [pair for pair in names if chance.random() < 0.6]
    return "{" + ", ".join(f"{name}: {fitting(chance, k, depth + 1)}" for name, k in some) + "}"


def words(chance: random.Random, cls: Any) -> list[str]:
    """The words of a command line."""
    kind = chance.random()
    if kind < 0.35:
        return [fitting(chance, each) for each in cls._slot_types]
    if kind < 0.9:
        given = fitting(chance, cls._type)
        while not given.startswith("{"):  # for a whole message ours takes a list, too
            given = fitting(chance, cls._type)
        return [given]
    return [yaml_texts.flow(chance) for _ in range(chance.randrange(1, 3))]


class Values(Kind):
    """The words of `rostopic pub`, by our command."""

    asked = "values"

    def draw(self, chance: random.Random) -> Case:
        kind = chance.choice(TYPES)
        return {"type": kind, "words": words(chance, message_class(kind))}

    def ours(self, case: Case) -> Answer:
        cls = message_class(case["type"])
        try:
            made = from_dict(cls, fields_of(case["words"], cls), now=Time(7, 8))
            return {"bytes": encode(made).hex()}
        except (RosError, ValueError) as error:
            return {"error": type(error).__name__, "says": str(error)}

    def theirs(self, case: Case, peer: Peer) -> Answer:
        answer = super().theirs(case, peer)
        answer.pop("text", None)  # genpy prints the values as they were typed
        return answer


class ValuesByLayer(Values):
    """The same by genpy of our layer."""

    def __init__(self, layer: Peer) -> None:
        self._layer = layer

    def ours(self, case: Case) -> Answer:
        return self._layer.ask(self.asked, case)

    def theirs(self, case: Case, peer: Peer) -> Answer:
        return Kind.theirs(self, case, peer)


def without_now(message: Any) -> None:
    """Replace the times of `now` and `auto` in a message, which differ between two calls."""
    for name in message.__slots__:
        value = getattr(message, name)
        if isinstance(value, Time) and abs(value.to_sec() - time.time()) < 600.0:
            setattr(message, name, Time(7, 8))
        elif isinstance(value, Message):
            without_now(value)


class RosserviceCall(Kind):
    """`rosservice call` beside `rosproto service call`, on the same service of ours; what arrives there is compared."""

    asked = "rosservice_command"
    services = (
        "std_srvs/SetBool",
        "std_srvs/Trigger",
        "nav_msgs/GetPlan",
        "sensor_msgs/SetCameraInfo",
        "roscpp/SetLoggerLevel",
    )

    def __init__(self, node: Node) -> None:
        self._uri = node.master_uri
        self._came: list[str] = []
        self._classes: dict[str, Any] = {}
        for kind in self.services:
            name = "/" + kind.partition("/")[2]
            node.service_server(name, kind, self._take)
            self._classes[name] = service_class(kind)

    def _take(self, request: Any) -> dict[str, object]:
        without_now(request)
        self._came.append(encode(request).hex())
        return {}

    def draw(self, chance: random.Random) -> Case:
        name = chance.choice(sorted(self._classes))
        request = self._classes[name].Request
        given = words(chance, request) or ["{}"]
        return {"service": name, "words": given, "stdin": ""}

    def theirs(self, case: Case, peer: Peer) -> Answer:
        return self._with_request(peer.ask(self.asked, case))

    def _with_request(self, answer: Answer) -> Answer:
        came, self._came[:] = list(self._came), []
        return answer if "error" in answer else {"out": answer["out"].rstrip(), "came": came}

    def ours(self, case: Case) -> Answer:
        with environment(ROS_MASTER_URI=self._uri):
            return self._with_request(
                run_command("service", "call", case["service"], *case["words"], stdin="")
            )


class RostopicEcho(Kind):
    """`rostopic echo -b` beside ours, on the same bag."""

    asked = "rostopic_echo"

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def draw(self, chance: random.Random) -> Case:
        kind = chance.choice(TYPES)
        cls: Any = message_class(kind)
        with tempfile.NamedTemporaryFile(dir=self._folder, suffix=".bag", delete=False) as file:
            path = file.name
        made = []
        with BagWriter(path) as bag:
            for number in range(chance.randrange(1, 4)):
                for _ in range(20):
                    try:
                        message = from_dict(cls, fields_of([fitting(chance, kind)], cls), now=Time(7, 8))
                        encode(message)
                    except (RosError, ValueError):
                        continue
                    bag.write("/t", message, float(number + 1))
                    made.append(str(message))
                    break
        options = [
            word
            for option in (["-p"], ["--noarr"], ["--nostr"], ["-n", "1"], ["-w", "8"])
            if chance.random() < 0.2
            for word in option
        ]
        topic = ["-a"] if chance.random() < 0.2 else ["/t" + self._field(chance, cls)]
        return {"bag": path, "words": [*topic, *options], "messages": made, "type": kind}

    def _field(self, chance: random.Random, cls: Any) -> str:
        if not cls.__slots__ or chance.random() < 0.6:
            return ""
        at = chance.randrange(len(cls.__slots__))
        kind = cls._slot_types[at]
        path = "/" + cls.__slots__[at]
        if kind.endswith("]"):
            path += chance.choice(["", "[0]", "[-1]", "[0:2]", "[1:]", "[::2]"])
        elif "/" in kind:
            path += self._field(chance, message_class(kind))
        return path

    def ours(self, case: Case) -> Answer:
        answer = run_command("topic", "echo", *case["words"], "-b", case["bag"])
        return {key: answer[key] for key in ("out", "error", "says") if key in answer}

    def theirs(self, case: Case, peer: Peer) -> Answer:
        return peer.ask(self.asked, case)


REPLIES = {
    "SetBoolResponse": [
        "None", "True", "[]", "[True]", "[True, 'x']", "(False, 'y')", "{'success': True}", "{'success': True, 'message': 'z'}", "{'no': 1}", "{}",
        "SetBoolResponse()", "SetBoolResponse(True, 'a')", "TriggerResponse(True, 'b')", "'text'", "1", "[1, 2, 3]", "('x', True)", "[2, 'x']",
        "[True, 5]", "[True, b'x']", "[True, '\u4e2d']", "{'success': None}", "[None, None]", "SetBoolResponse(success='x')", "EmptyResponse()", "0",
        "{'message': 'm'}", "[True, ['x']]", "SetBoolRequest(True)", "Bool(True)", "(True,)", "[1.0, 'x']", "True, 'tuple'",
    ],
    "EmptyResponse": ["None", "[]", "{}", "EmptyResponse()", "True", "[1]", "()", "''", "0", "{'a': 1}"],
    "TriggerResponse": ["SetBoolResponse(True, 'x')", "[True, 'x']", "(1, 'x')", "TriggerResponse(message='q')", "{'success': 1, 'message': 'x'}"],
}  # fmt: skip
PUBLISHED = {
    "String": ["'x'", "data='x'", "String('x')", "5", "None", "", "'\u4e2d'", "b'\\xff'", "String(data=5)", "'a', 'b'", "nodata='x'", "['x']", "Bool(True)"],
    "Int8": ["5", "128", "-129", "5.0", "'5'", "True", "None", "Int8(7)", "data=300", "UInt8(5)"],
    "UInt8": ["5", "256", "-1", "True", "5.5"],
    "Float32": ["1", "1.5", "1e39", "'x'", "True", "None", "float('nan')"],
    "Bool": ["True", "1", "2", "0", "'x'", "None", "[]"],
    "Header": ["5, rospy.Time(1, 2), 'm'", "frame_id='m'", "frame_id=None", "stamp=rospy.Time(1, 2)", "stamp=5", "Header()", "stamp=rospy.Duration(1)"],
    "Point": ["1, 2, 3", "1, 2", "x=1", "x='a'", "Point(1, 2, 3)", "[1, 2, 3]", "(1, 2, 3)", "Vector3(1, 2, 3)"],
    "Twist": ["Vector3(1, 0, 0), Vector3()", "linear=Vector3(1, 2, 3)", "Twist()", "linear=Point(1, 2, 3)", "Vector3(), None", "[1, 2, 3], [4, 5, 6]"],
    "PointStamped": ["Header(frame_id='a'), Point(1, 2, 3)", "point=Point(x=1)", "header=Header(seq=9)", "header=None", "PointStamped(header=Header(frame_id=None))"],
    "Polygon": ["[Point32(1, 2, 3)]", "points=[Point32()]", "points=(Point32(),)", "points=[Point()]", "points=None", "[]", "[1]", "points='x'"],
    "UInt8MultiArray": ["data=b'ab'", "data=[1, 2]", "data=(1, 2)", "data='ab'", "data=bytearray(b'ab')", "data=[256]", "data=[-1]", "data=None"],
    "Float64MultiArray": ["data=[1, 2.5]", "data=(1,)", "data=1", "data=['x']", "data=[True]"],
    "Time": ["rospy.Time(1, 2)", "data=rospy.Time(-1)", "5", "data=rospy.Duration(3)", "data=genpy.Time(4)"],
    "Duration": ["rospy.Duration(-1, 2)", "rospy.Duration(1 << 31)", "data=None"],
    "Empty": ["", "Empty()", "1", "None", "a=1"],
}  # fmt: skip


class Handed(Kind):
    """What programs hand to publish(), or return from a handler, in both layers."""

    def __init__(self, layer: Peer, asked: str, choices: dict[str, list[str]]) -> None:
        self._layer, self.asked, self._choices = layer, asked, choices

    @property
    def name(self) -> str:
        return self.asked.capitalize()

    def draw(self, chance: random.Random) -> Case:
        cls = chance.choice(sorted(self._choices))
        if chance.random() < 0.2:
            other = chance.choice(sorted(self._choices))
            return {"class": cls, "value": chance.choice(self._choices[other])}
        return {"class": cls, "value": chance.choice(self._choices[cls])}

    def ours(self, case: Case) -> Answer:
        return self._layer.ask(self.asked, case)


DATATYPES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 8: 8}


class Cloud(Kind):
    """sensor_msgs.point_cloud2, in both layers."""

    asked = "cloud"

    def __init__(self, layer: Peer) -> None:
        self._layer = layer

    def draw(self, chance: random.Random) -> Case:
        fields, offset = [], 0
        for name in chance.sample(["x", "y", "z", "i", "rgb"], chance.randrange(1, 5)):
            offset += chance.choice([0, 0, 0, 1, 4])
            datatype = chance.choice(
                [7, 7, 7, 8, 1, 2, 3, 4, 5, 6, *([0, 9] if chance.random() < 0.05 else [])]
            )
            count = chance.choice([1, 1, 1, 1, 2, 0])
            fields.append([name, offset, datatype, count])
            offset += DATATYPES.get(datatype, 4) * count
        if chance.random() < 0.1:
            chance.shuffle(fields)
        if fields and chance.random() < 0.1:
            chance.choice(fields)[1] = chance.randrange(
                offset + 1
            )  # overlaps another, or ends behind the point
        step = max(0, offset + chance.choice([0, 0, 0, 3, -1 if chance.random() < 0.1 else 0]))
        names = (
            None
            if chance.random() < 0.5
            else chance.sample([f[0] for f in fields] + ["q"] * (chance.random() < 0.1), 1)
        )
        uvs = [] if chance.random() < 0.8 else [[chance.randrange(3), chance.randrange(2)] for _ in range(2)]
        case: Case = {"fields": fields, "names": names, "skip_nans": chance.random() < 0.3, "uvs": uvs}
        if chance.random() < 0.3:
            case["points"] = [
                [chance.choice([0, 1, 2.5, -1, 200]) for f in fields for _ in range(max(1, f[3]))]
                for _ in range(chance.randrange(4))
            ]
            return case
        width, height = chance.choice([0, 1, 2, 3, 3, 20]), chance.choice([1, 1, 2, 2, 4, 0])
        row = max(0, step * width + chance.choice([0, 0, 0, 5, 16, -1 if chance.random() < 0.1 else 0]))
        size = row * height if chance.random() < 0.95 else max(0, row * height - 3)
        data = b"".join(
            chance.choice([b"\0", b"\x01", b"\x7f\xc0", b"\xc0\x7f", b"\xff", b"\x80\x3f"])
            for _ in range(size)
        )[:size]
        shape = {
            "width": width,
            "height": height,
            "point_step": step,
            "row_step": row,
            "is_bigendian": chance.random() < 0.3,
            "is_dense": chance.random() < 0.3,
        }
        return {**case, "data": data.hex(), "shape": shape}

    def ours(self, case: Case) -> Answer:
        return self._layer.ask(self.asked, case)
