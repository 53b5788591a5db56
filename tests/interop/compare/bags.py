"""Bags: random topics, types, connections, times, compressions and damages, read and rewritten by both."""

from __future__ import annotations

import random
import re
import shutil
import struct
import time
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from rosproto import BagReader, BagWriter, message_class
from rosproto.bag.records import Connection
from rosproto.cli.yaml_values import fields_of
from rosproto.codec import AnyMsg, define, encode
from rosproto.codec.dicts import from_dict
from rosproto.errors import RosError
from rosproto.node import Node
from rosproto.time import Time
from tests.interop.compare.asked import plain
from tests.interop.compare.comparison import ERROR, Answer, Case, Kind, Peer, run_command
from tests.interop.compare.comparison import environment as variables
from tests.interop.compare.values import fitting
from tests.support.load import crowd
from tests.support.ros_process import RosProcess, environment

OUT_OF_RANGE = "Time is out of dual 32-bit range"
TOPICS = ["/a", "/b", "/c/d", "e", "/camera/image", "/tf"]
TYPES = ["std_msgs/String", "std_msgs/Int32", "std_msgs/Empty", "geometry_msgs/PointStamped", "std_msgs/UInt8MultiArray", "tf2_msgs/TFMessage"]  # fmt: skip
OWN = {
    "p/Odd": ["int8 a\nstring b\n", "int8 a\nint8 c\n"],
    "q/Deep": [f"p/Odd[] odd\nHeader header\n{'=' * 80}\nMSG: p/Odd\nint8 a\n{'=' * 80}\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"],
}  # fmt: skip
NS = 1_000_000_000
MAX_NS = 2**32 * NS - 1  # the last time that a message can have
UNUSABLE = ["", 'syntax = "proto3";', "no_such_pkg/Type x\n", "int8 a b c\n"]
EXPRESSIONS = [
    "True", "False", "topic == '/a'", "topic in ('/a', '/b')", "topic != '/c/d'", "t.secs > 2", "t.to_sec() < 3.0", "t.nsecs == 0",
    "m._type == 'std_msgs/String'", "topic == '/b' and t.secs > 1", "topic.startswith('/c')", "t.secs", "not topic == 'e'",
]  # fmt: skip


def _connection(chance: random.Random, number: int, usable: bool) -> Connection:
    kind = chance.random()
    if kind < 0.75:
        cls: Any = message_class(chance.choice(TYPES))
        name, text = cls._type, cls._full_text
    else:
        name = chance.choice(sorted(OWN))
        text = chance.choice(OWN[name])
        cls = define(name, text)
    md5sum = cls._md5sum
    if not usable:
        text = chance.choice(UNUSABLE)
        name, md5sum = "p/Unusable", f"{number:032x}"
    header = {}
    if chance.random() < 0.6:
        header = {"callerid": chance.choice(["/n", "/m", "/robot/n", "n"]), "latching": chance.choice("01")}
    if chance.random() < 0.1:
        header["extra"] = chance.choice(["", "x=y", "\u4e2d"])
    return Connection(0, chance.choice(TOPICS), name, md5sum, text, header)


def _data(chance: random.Random, connection: Connection) -> bytes:
    try:
        cls: Any = define(connection.type, connection.definition)
    except RosError:
        return bytes(chance.randrange(4))
    for _ in range(20):
        try:
            values = (
                fields_of([fitting(chance, kind) for kind in cls._slot_types], cls)
                if "/" not in cls._type[:2]
                else None
            )
            return encode(from_dict(cls, values, now=Time(7, 8)))
        except (RosError, ValueError):
            continue
    return encode(cls())


def write_bag(chance: random.Random, path: Path, *, ordered: bool) -> bool:
    """Write a bag with what recorders and editors leave; its chunks overlap unless it is ordered.

    Returns:
        Whether a topic has several connections.
    """
    usable = chance.random() < 0.9
    connections = [_connection(chance, n, usable or n > 0) for n in range(chance.randrange(1, 6))]
    with BagWriter(
        path, chance.choice(["none", "none", "bz2", "lz4"]), chance.choice([100, 300, 768 * 1024])
    ) as bag:
        now = chance.choice([0, 1, 1_600_000_000, 4_294_967_290])
        times = [
            (now + chance.randrange(5), chance.choice([0, 0, 1, 500_000_000, 999_999_999]))
            for _ in range(chance.choice([0, 1, 3, 10, 40]))
        ]
        for stamp in sorted(times) if ordered else times:
            connection = chance.choice(connections)
            bag.write_raw(connection, _data(chance, connection), Time(*stamp))
            if chance.random() < 0.03:
                bag.set_chunks(chance.choice(["none", "bz2", "lz4"]), chance.choice([100, 300, 2000]))
    return len({connection.topic for connection in connections}) < len(connections)


def damage(chance: random.Random, path: Path) -> str:
    """Damage a bag, as a crash or a bad copy does; in words."""
    data = bytearray(path.read_bytes())
    kind = chance.choice(["cut", "cut", "no index", "byte", "behind"])
    index = int.from_bytes(data[data.index(b"index_pos=") + 10 :][:8], "little")
    if kind == "cut":
        at = chance.randrange(4117, len(data)) if len(data) > 4117 else len(data)
        del data[at:]
    elif kind == "no index":
        del data[chance.choice([index, index, len(data)]) :]
        place = data.index(b"index_pos=") + 10
        data[place : place + 8] = struct.pack("<Q", 0)
    elif kind == "byte":
        at = chance.randrange(4117, len(data)) if len(data) > 4117 else 0
        data[at] ^= 1 << chance.randrange(8)
    else:
        data += chance.choice([b"\0" * 50, b"\n", bytes(data), b"text"])
    path.write_bytes(data)
    return kind


class BagKind(Kind):
    """A kind whose cases are bags.

    Attributes:
        damaged: Share of the bags that are damaged.
    """

    damaged = 0.2

    def __init__(self, folder: Path, layer: Peer) -> None:
        self._folder, self._layer = folder / self.name, layer
        self._folder.mkdir()

    def draw(self, chance: random.Random) -> Case:
        for old in self._folder.iterdir():
            shutil.rmtree(old)
        self._home = self._folder / f"{chance.getrandbits(32):08x}"
        self._home.mkdir()
        path = self._home / "in.bag"
        ordered = chance.random() < 0.7
        shared = write_bag(chance, path, ordered=ordered)
        state = damage(chance, path) if chance.random() < self.damaged else "sound"
        return {
            "bag": str(path),
            "state": state,
            "ordered": ordered,
            "shared": shared,
            **self.question(chance),
        }

    def question(self, chance: random.Random) -> Case:
        """Return what is asked about the bag."""
        raise NotImplementedError


class BagRead(BagKind):
    """rosbag.Bag of both layers: messages, and what there is to tell about a bag."""

    asked = "bag_read"

    def question(self, chance: random.Random) -> Case:
        topics = chance.choice([None, None, None, "/a", ["/a", "/b"], ["a"], [], ["/nosuch"], ["e"]])
        start = chance.choice([None, None, None, [0, 0], [1, 500_000_000], [1_600_000_002, 0]])
        end = chance.choice([None, None, None, [3, 0], [1_600_000_003, 1]])
        return {"topics": topics, "start": start, "end": end, "allow_unindexed": chance.random() < 0.3}

    def ours(self, case: Case) -> Answer:
        return self._layer.ask(self.asked, case)


class BagInfo(BagKind):
    """`rosbag info`, as text and YAML."""

    asked = "bag_command"

    def question(self, chance: random.Random) -> Case:
        words = [
            chance.choice(
                [
                    [],
                    ["-y"],
                    [
                        "-y",
                        "-k",
                        chance.choice(["types", "topics", "duration", "messages", "compression", "x"]),
                    ],
                ]
            )
        ]
        words += [["--freq"]] if chance.random() < 0.2 else []
        return {"words": ["info", *(word for part in words for word in part)]}

    def theirs(self, case: Case, peer: Peer) -> Answer:
        return peer.ask(self.asked, {"words": [*case["words"], case["bag"]]})

    def ours(self, case: Case) -> Answer:
        answer = run_command(
            "bag", *case["words"], *([] if "-y" in case["words"] else ["--plain"]), case["bag"]
        )
        return {key: answer[key] for key in ("out", "error", "says") if key in answer}

    def same(self, theirs: Answer, ours: Answer) -> bool:
        """YAML is compared by its values."""
        return super().same(_as_yaml(theirs), _as_yaml(ours))


def _as_yaml(answer: Answer) -> Answer:
    try:
        return {**answer, "out": plain(yaml.safe_load(answer["out"]))} if "out" in answer else answer
    except yaml.YAMLError:
        return answer


class Rewritten(BagKind):
    """A kind that makes a new bag of a bag; what each made, each reads."""

    asked = "bag_command"
    made: tuple[str, ...] = ("out.bag",)
    shown = ""

    def theirs(self, case: Case, peer: Peer) -> Answer:
        self._peer = peer
        home = self._copy(case, "theirs")
        answer = peer.ask(self.asked, {"words": self._words(case, home)})
        return self._told(answer, home, peer)

    def ours(self, case: Case) -> Answer:
        home = self._copy(case, "ours")
        return self._told(run_command("bag", *self._words(case, home)), home, self._peer)

    def _copy(self, case: Case, name: str) -> Path:
        home = Path(case["bag"]).parent / name
        home.mkdir()
        shutil.copy(case["bag"], home / "in.bag")
        return home

    @staticmethod
    def _words(case: Case, home: Path) -> list[str]:
        return [word.replace("DIR", str(home)) for word in case["words"]]

    def _told(self, answer: Answer, home: Path, peer: Peer) -> Answer:
        """The messages of what came out, as both read it, and the lines that a tool was asked to print."""
        found: Answer = {name: self._messages(home / name, peer) for name in self.made}
        # rosbag's progress line ends without a line end.
        found["lines"] = re.findall(self.shown, answer.get("out", "")) if self.shown else []
        found["says"] = str(answer.get("says", ""))
        return found

    def _messages(self, path: Path, peer: Peer) -> Answer:
        answers = [
            one.ask("bag_read", {"bag": str(path), "allow_unindexed": False}) for one in (peer, self._layer)
        ]
        both = [{"messages": answer["messages"]} if "messages" in answer else answer for answer in answers]
        return (
            both[0]
            if in_one_order(both[0]) == in_one_order(both[1])
            else {"debian": both[0], "ours": both[1]}
        )

    def same(self, theirs: Answer, ours: Answer) -> bool:
        return super().same(*({**answer, "says": ""} for answer in (theirs, ours)))


class BagFilter(Rewritten):
    """`rosbag filter` beside `rosproto bag filter`."""

    damaged = 0.1
    shown = r"(?:NO )?MATCH [^\r\n]*"

    def question(self, chance: random.Random) -> Case:
        words = ["filter", "DIR/in.bag", "DIR/out.bag", chance.choice(EXPRESSIONS)]
        if chance.random() < 0.3:
            words += ["--print", chance.choice(["topic", "t.secs", "m._type", "t"])]
        return {"words": words}


class BagReindex(Rewritten):
    """`rosbag reindex` beside ours, of bags that recorders left behind."""

    damaged = 0.9
    made = ("in.bag",)

    def question(self, chance: random.Random) -> Case:
        return {"words": ["reindex", "-q", "DIR/in.bag"]}


class BagFix(Rewritten):
    """`rosbag fix` beside ours."""

    damaged = 0.1

    def question(self, chance: random.Random) -> Case:
        return {"words": ["fix", "DIR/in.bag", "DIR/out.bag"]}


class BagCompress(Rewritten):
    """`rosbag compress` and `decompress` beside ours."""

    damaged = 0.1
    made = ("in.bag",)

    def question(self, chance: random.Random) -> Case:
        return {
            "words": [
                *chance.choice([["compress"], ["compress", "--lz4"], ["decompress"]]),
                "-q",
                "DIR/in.bag",
            ]
        }


class BagPlay(BagKind):
    """`rosbag play` beside ours: what a subscriber of ours receives."""

    damaged = 0.0

    def __init__(self, folder: Path, layer: Peer, node: Node) -> None:
        super().__init__(folder, layer)
        self._uri = node.master_uri
        self._came: dict[str, list[str]] = {}
        self._last = 0.0
        self._ours: Answer = {}
        for topic in (self._heard_as(name, way) for way in ([], ["--prefix"]) for name in TOPICS):
            node.subscriber(topic, AnyMsg, partial(self._take, topic), queue_size=1000)

    def _take(self, topic: str, message: Any) -> None:
        self._came.setdefault(topic, []).append(bytes(message._buff).hex())
        self._last = time.monotonic()

    def question(self, chance: random.Random) -> Case:
        options = [
            word
            for option in (
                ["--topics", "/a", "e", "/b"],
                ["-s", "1"],
                ["-u", "2"],
                ["--prefix", "/robot"],
                ["-r", "5"],
            )
            if chance.random() < 0.2
            for word in option
        ]
        with BagReader(self._home / "in.bag") as bag:
            latched = [one.topic for one in bag.connections.values() if one.latching]
            stamps = [(topic, stamp.to_nsec()) for topic, _, stamp in bag.read_messages(raw=True)]
        first = min((stamp for _, stamp in stamps), default=0) + ("-s" in options) * NS
        last = first + 2 * NS if "-u" in options else MAX_NS
        times: dict[str, list[int]] = {}
        for topic, stamp in stamps:
            if first <= stamp <= last:
                times.setdefault(self._heard_as(topic, options), []).append(stamp)
        return {
            "options": options,
            "latched": [self._heard_as(topic, options) for topic in latched],
            "at_zero": [self._heard_as(topic, options) for topic, stamp in stamps if not stamp],
            "times": times,
        }

    @staticmethod
    def _heard_as(topic: str, options: list[str]) -> str:
        prefix = "/robot" if "--prefix" in options else ""
        return f"/{(prefix + topic).lstrip('/')}"

    def theirs(self, case: Case, peer: Peer) -> Answer:
        self._ours = self._play(case)  # first: what it sends is what is waited for
        command = [
            "/usr/lib/rosbag/play",
            "-q",
            "--immediate",
            "--keep-alive",
            "--wait-for-subscribers",
            *self._words(case),
        ]
        with RosProcess(command, environment(self._uri)) as process:
            self._last = time.monotonic() + 1.0  # it starts
            while process.running and not self._is_quiet(self._patience()):
                time.sleep(0.01)
            process.stop(patience=1.0)  # one that waits for subscribers takes no notice of Ctrl-C
            if OUT_OF_RANGE in process.output:
                return self._took(OUT_OF_RANGE)
            return self._took(ERROR if not process.running and "rror" in process.output else "")

    def _patience(self) -> float:
        """Seconds of silence after which nothing more is expected; on a busy computer the player starts late."""
        if self._came == self._ours["came"]:
            return 0.05
        return (1.0 if self._came else 5.0) * crowd()

    @staticmethod
    def _words(case: Case) -> list[str]:
        return [*case["options"], *(["--bags"] if "--topics" in case["options"] else []), case["bag"]]

    def ours(self, case: Case) -> Answer:
        return self._ours

    def _play(self, case: Case) -> Answer:
        with variables(ROS_MASTER_URI=self._uri):
            answer = run_command(
                "bag", "play", "-q", "--immediate", "--wait-for-subscribers", *self._words(case)
            )
        self._last = time.monotonic()
        while not self._is_quiet(0.1):
            time.sleep(0.01)
        return self._took(answer.get("says", ""))

    def _is_quiet(self, seconds: float) -> bool:
        """Whether nothing has come for so long."""
        return time.monotonic() > self._last + seconds

    def _took(self, says: str) -> Answer:
        came, self._came = self._came, {}
        return {"came": came, "says": says}

    def same(self, theirs: Answer, ours: Answer) -> bool:
        return bool(theirs["came"] == ours["came"])


def in_one_order(answer: Answer) -> Answer:
    """An answer with its messages sorted, and without what depends on the order of overlapping chunks."""
    if not isinstance(answer, dict):
        return answer
    if "messages" not in answer:
        return {key: sorted(item) if key == "lines" else in_one_order(item) for key, item in answer.items()}
    facts = {k: v for k, v in answer.get("facts", {}).items() if k not in ("get_start_time", "get_end_time")}
    known = facts.get("get_type_and_topic_info")
    if isinstance(known, list):
        facts["get_type_and_topic_info"] = [
            known[0],
            [[topic, *values[:3]] for topic, values in known[1]["dict"]],
        ]
    return {**answer, "facts": facts, "messages": sorted(answer["messages"], key=repr)}


def ties_in_one_order(answer: Answer) -> Answer:
    """An answer with its messages of the same time sorted."""
    if isinstance(answer, dict) and "messages" in answer:
        return {**answer, "messages": sorted(answer["messages"], key=lambda row: (row[4], repr(row)))}
    return (
        {key: ties_in_one_order(item) for key, item in answer.items()} if isinstance(answer, dict) else answer
    )


def without_connections(answer: Answer) -> Answer:
    """An answer in one order, with topic, bytes and time of each message alone."""
    if isinstance(answer, dict) and "messages" in answer:
        return {"messages": sorted([row[0], row[2], row[4]] for row in answer["messages"])}
    return (
        {key: without_connections(item) for key, item in answer.items()}
        if isinstance(answer, dict)
        else answer
    )
