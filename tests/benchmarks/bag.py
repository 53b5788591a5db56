"""Bags beside rosbag and rosbags, on one interpreter, interleaved; every file complete and valid.

    PYTHONPATH=.:<site-packages with numpy, lz4 and rosbags> /usr/bin/python3 -m tests.benchmarks bag

Each cell is the median of three rounds; in a round all peers take turns, each in a process of its own (what one
asks of the allocator must not help or hurt the others). Ratios are peer time / our time, so more is better; "cpu"
is our processor time over our wall time, and behind a peer its processor time over ours (for a busy machine).
"read" decodes every message. "floor" is the time of bare write() or readinto() calls for the same bytes: no
program can be faster. Files lie in /dev/shm where there is one. Options: --small N messages, --mixed MB,
--pictures MB, --overlapping MB (bags whose chunks overlap in time, read only), --open MB (a bag to be opened and
listed; 2000 for the 2 GB case), --rounds N, --only TEXT; --memory reads the bag of the open case and prints what that took.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from rosproto.bag import BagReader, BagWriter
from rosproto.codec import encode, message_class
from rosproto.time import Time
from tests.benchmarks.codec import Rosbags, genpy_classes

Entry = tuple[str, Any, int]


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks bag")
    parser.add_argument("--small", type=int, default=200_000, help="messages in the bag of small ones")
    parser.add_argument("--mixed", type=int, default=200, help="MB in the mixed bag")
    parser.add_argument("--pictures", type=int, default=200, help="MB in the bag of large pictures")
    parser.add_argument("--overlapping", type=int, default=150, help="MB in the bags whose chunks overlap")
    parser.add_argument("--open", type=int, default=400, help="MB in the bag that is opened")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", default="", help="cases that contain this text")
    parser.add_argument("--memory", action="store_true", help="also the memory of reading the large bag")
    args = parser.parse_args(arguments)
    place = "/dev/shm" if os.path.isdir("/dev/shm") else None
    with tempfile.TemporaryDirectory(dir=place) as folder, genpy_classes() as genpy_class:
        peers = [peer for peer in (Ours(), Genuine.create(genpy_class), RosbagsPeer.create()) if peer]
        print(
            f"python {sys.version.split()[0]}; {', '.join(p.name for p in peers)}; medians of {args.rounds}"
        )
        print(f"{'case':34} {'ours':>12}  ratios")
        for label, compression, entries in cases(args):
            if args.only in label:
                compare(label, compression, entries, peers, Path(folder), args.rounds)
        for compression in ("none", "lz4", "bz2"):
            for written in ("by topic", "shuffled"):
                if args.only in (label := f"overlapping {written} {compression}"):
                    overlapping(label, compression, written, args, peers, Path(folder))
        if args.only in "open and list":
            opening(args, peers, Path(folder))


def cases(args: argparse.Namespace) -> Iterator[tuple[str, str, list[Entry]]]:
    small = small_entries(args.small)
    yield "small lz4", "lz4", small
    yield "small none", "none", small
    mixed = mixed_entries(args.mixed)
    yield "mixed lz4", "lz4", mixed
    yield "mixed none", "none", mixed
    yield "pictures lz4", "lz4", picture_entries(args.pictures)


def small_entries(count: int) -> list[Entry]:
    twist = message_class("geometry_msgs/Twist")()
    twist.linear.x = 0.25
    return [("/cmd_vel", twist, 10**18 + i * 10**6) for i in range(count)]


def picture_entries(megabytes: int) -> list[Entry]:
    """Pictures of 6 MB, each a chunk of its own; pixels half noise, half even."""
    import numpy as np

    image = message_class("sensor_msgs/Image")()
    image.height, image.width, image.encoding, image.step = 1080, 1920, "rgb8", 5760
    image.data = np.zeros(1080 * 5760, np.uint8)
    image.data[::2] = np.random.default_rng(1).integers(0, 256, 1080 * 2880, np.uint8)
    count = max(1, megabytes * 1_000_000 // len(image.data))
    return [("/image", image, 10**18 + i * 10**8) for i in range(count)]


def mixed_entries(megabytes: int) -> list[Entry]:
    """Camera, laser, odometry, velocity as a robot sends them; pixels half noise, half even."""
    import numpy as np

    rng = np.random.default_rng(1)
    image, scan, odometry, twist = [
        message_class(name)()
        for name in ("sensor_msgs/Image", "sensor_msgs/LaserScan", "nav_msgs/Odometry", "geometry_msgs/Twist")
    ]
    image.height, image.width, image.encoding, image.step = 480, 640, "mono8", 640
    image.data = np.zeros(640 * 480, np.uint8)
    image.data[::2] = rng.integers(0, 256, 320 * 480, np.uint8)
    scan.ranges = np.linspace(1, 9, 1080, dtype=np.float32)
    scan.intensities = np.full(1080, 100, np.float32)
    for message in (image, scan, odometry):
        message.header.frame_id = "base_link"
    second = (
        [("/image", image)] * 15
        + [("/scan", scan)] * 20
        + [("/odom", odometry)] * 50
        + [("/cmd_vel", twist)] * 20
    )
    entries: list[Entry] = []
    size = 0
    while size < megabytes * 1_000_000:
        for topic, message in second:
            entries.append((topic, message, 10**18 + len(entries) * 10**7))
        size += 15 * 307_300 + 20 * 8_700 + 50 * 730 + 20 * 48
    return entries


class Ours:
    """rosproto.bag."""

    name = "ours"

    def prepare(self, entries: list[Entry]) -> list[Any]:
        return [(topic, message, Time(*divmod(stamp, 10**9))) for topic, message, stamp in entries]

    def write(self, path: Path, compression: str, prepared: list[Any]) -> None:
        with BagWriter(path, compression) as bag:  # type: ignore[arg-type]
            for topic, message, stamp in prepared:
                bag.write(topic, message, stamp)

    def read(self, path: Path) -> int:
        with BagReader(path) as bag:
            return sum(1 for _ in bag.read_messages())

    def raw(self, path: Path) -> int:
        with BagReader(path) as bag:
            return sum(1 for _ in bag.read_messages(raw=True))

    def open(self, path: Path) -> int:
        with BagReader(path) as bag:
            return sum(info.message_count for info in bag.topics.values())


class Genuine:
    """Debian's rosbag."""

    name = "rosbag"

    def __init__(self, find: Callable[[str], Any]) -> None:
        self._find = find

    @classmethod
    def create(cls, find: Callable[[str], Any] | None) -> Genuine | None:
        try:
            import rosbag  # noqa: F401
        except ImportError:
            return None
        return cls(find) if find else None

    def prepare(self, entries: list[Entry]) -> list[Any]:
        import rospy

        known: dict[int, Any] = {}
        for _, message, _ in entries:
            if id(message) not in known:
                theirs = self._find(message._type)()
                theirs.deserialize(encode(message))
                known[id(message)] = theirs
        return [(t, known[id(m)], rospy.Time(*divmod(stamp, 10**9))) for t, m, stamp in entries]

    def write(self, path: Path, compression: str, prepared: list[Any]) -> None:
        import rosbag

        with rosbag.Bag(str(path), "w", compression=compression) as bag:
            for topic, message, stamp in prepared:
                bag.write(topic, message, stamp)

    def read(self, path: Path) -> int:
        import rosbag

        with rosbag.Bag(str(path)) as bag:
            return sum(1 for _ in bag.read_messages())

    def raw(self, path: Path) -> int:
        import rosbag

        with rosbag.Bag(str(path)) as bag:
            return sum(1 for _ in bag.read_messages(raw=True))

    def open(self, path: Path) -> int:
        import rosbag

        with rosbag.Bag(str(path)) as bag:
            return sum(t.message_count for t in bag.get_type_and_topic_info().topics.values())


class RosbagsPeer:
    """The rosbags package."""

    name = "rosbags"

    def __init__(self, codec: Rosbags) -> None:
        self._store = codec.store

    @classmethod
    def create(cls) -> RosbagsPeer | None:
        codec = Rosbags.create()
        return cls(codec) if codec else None

    def prepare(self, entries: list[Entry]) -> list[Any]:
        known: dict[int, Any] = {}
        for _, message, _ in entries:
            if id(message) not in known:
                name = message._type.replace("/", "/msg/")
                known[id(message)] = name, self._store.deserialize_ros1(encode(message), name)
        return [(topic, *known[id(message)], stamp) for topic, message, stamp in entries]

    def write(self, path: Path, compression: str, prepared: list[Any]) -> None:
        from rosbags.rosbag1 import Writer

        path.unlink(missing_ok=True)
        writer = Writer(path)
        if compression != "none":
            writer.set_compression(Writer.CompressionFormat[compression.upper()])
        store = self._store
        with writer:
            connections: dict[str, Any] = {}
            for topic, name, message, stamp in prepared:
                connection = connections.get(topic)
                if connection is None:
                    connection = connections[topic] = writer.add_connection(topic, name, typestore=store)
                writer.write(connection, stamp, store.serialize_ros1(message, name))

    def read(self, path: Path) -> int:
        from rosbags.rosbag1 import Reader

        store = self._store
        with Reader(path) as bag:
            return sum(1 for c, _, raw in bag.messages() if store.deserialize_ros1(raw, c.msgtype))

    def raw(self, path: Path) -> int:
        from rosbags.rosbag1 import Reader

        with Reader(path) as bag:
            return sum(1 for _ in bag.messages())

    def open(self, path: Path) -> int:
        from rosbags.rosbag1 import Reader

        with Reader(path) as bag:
            return sum(info.msgcount for info in bag.topics.values())


class Floor:
    """What the operating system takes for the bytes alone, in pieces of a chunk's size."""

    name = "floor"

    def prepare(self, entries: list[Entry]) -> list[Any]:
        return entries

    def write(self, path: Path, compression: str, prepared: list[Any]) -> None:
        piece = memoryview(bytes(range(256)) * 3600)
        with open(path, "wb", buffering=0) as file:
            left = _bytes(prepared)
            while left > 0:
                left -= file.write(piece[:left])

    def read(self, path: Path) -> int:
        buffer = bytearray(900_000)
        with open(path, "rb", buffering=0) as file:
            while file.readinto(buffer):
                pass
        return 0

    raw = read


class Turn:
    """A peer in a process of its own, asked to do one thing at a time."""

    def __init__(self, peer: Any, entries: list[Entry]) -> None:
        context = multiprocessing.get_context("fork")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=self._serve, args=(peer, entries, theirs), daemon=True)
        self._process.start()

    def ask(self, verb: str, *arguments: Any) -> tuple[Any, float, float]:
        """What the peer answers, its wall time and its processor time, seconds."""
        self._pipe.send((verb, arguments))
        answer: tuple[Any, float, float] = self._pipe.recv()
        return answer

    def close(self) -> None:
        self._pipe.send(None)
        self._process.join()

    @staticmethod
    def _serve(peer: Any, entries: list[Entry], pipe: Any) -> None:
        prepared = peer.prepare(entries)
        while (request := pipe.recv()) is not None:
            verb, arguments = request
            if verb == "write":
                arguments = (*arguments, prepared)
            began, busy = time.perf_counter(), time.process_time()
            answer = getattr(peer, verb)(*arguments)
            pipe.send((answer, time.perf_counter() - began, time.process_time() - busy))


Times = dict[tuple[str, str], list[float]]


def compare(
    label: str, compression: str, entries: list[Entry], peers: list[Any], folder: Path, rounds: int
) -> None:
    """Write, read and read raw; every peer reads the bag that we wrote (rosbag cannot open rosbags' LZ4)."""
    size = _bytes(entries)
    turns = {peer.name: Turn(peer, entries) for peer in [*peers, Floor()]}
    paths = {name: folder / f"{name}.bag" for name in turns}
    times: Times = {}
    for _ in range(rounds):
        for name, turn in turns.items():
            paths[name].unlink(missing_ok=True)  # or giving its old pages back is what is measured
            clock(times, name, turn, "write", paths[name], compression)
        for verb in ("read", "raw"):
            for name, turn in turns.items():
                count = clock(times, name, turn, verb, paths["ours"])
                assert count == (0 if name == "floor" else len(entries)), (label, verb, name, count)
    for verb in ("write", "read", "raw"):
        report(f"{label} {verb}", times, verb, [*turns], len(entries), size)
    for name, turn in turns.items():
        turn.close()
        paths[name].unlink()


def overlapping_entries(megabytes: int, written: str) -> list[Entry]:
    """Messages of 50 kB of text, 16 topics: one topic after the other, or in no order of time."""
    import numpy as np

    rng = np.random.default_rng(1)
    message = message_class("std_msgs/UInt8MultiArray")()
    words = rng.integers(0, 256, (4000, 6), np.uint8)
    message.data = words[rng.integers(0, 4000, 8300)].ravel()
    count = megabytes * 20
    stamps = range(count) if written == "by topic" else rng.permutation(count)
    entries = [(f"/data{stamp % 16}", message, 10**18 + int(stamp) * 10**7) for stamp in stamps]
    return sorted(entries, key=lambda entry: entry[0]) if written == "by topic" else entries


def overlapping(
    label: str, compression: str, written: str, args: argparse.Namespace, peers: list[Any], folder: Path
) -> None:
    """Read a bag whose chunks overlap in time; of shuffled ones, rosbag and rosbags do not give the order of time."""
    entries = overlapping_entries(args.overlapping, written)
    path = folder / "overlapping.bag"
    Ours().write(path, compression, Ours().prepare(entries))
    turns = {peer.name: Turn(peer, []) for peer in peers}
    times: Times = {}
    for _ in range(args.rounds):
        for verb in ("read", "raw"):
            for name, turn in turns.items():
                assert clock(times, name, turn, verb, path) == len(entries), (label, verb, name)
    for verb in ("read", "raw"):
        report(f"{label} {verb}", times, verb, [*turns], len(entries), _bytes(entries))
    for turn in turns.values():
        turn.close()


def opening(args: argparse.Namespace, peers: list[Any], folder: Path) -> None:
    """Open a large bag and list its topics with their counts."""
    entries = mixed_entries(args.open)
    path = folder / "large.bag"
    Ours().write(path, "none", Ours().prepare(entries))
    turns = {peer.name: Turn(peer, []) for peer in peers}
    times: Times = {}
    for _ in range(args.rounds):
        for name, turn in turns.items():
            assert clock(times, name, turn, "open", path) == len(entries)
    report(f"open and list {path.stat().st_size / 1e6:.0f} MB", times, "open", [*turns], 1, 0)
    for turn in turns.values():
        turn.close()
    if args.memory:
        memory(path)


def memory(path: Path) -> None:
    """Peak memory (Linux) of a process that reads a bag through, and before it reads."""
    code = (
        "import sys, numpy; from rosproto.bag import BagReader; bag = BagReader(sys.argv[1])\n"
        "def peak(): return [int(l.split()[1]) // 1024 for l in open('/proc/self/status') if 'VmHWM' in l][0]\n"
        "before = peak(); n = sum(1 for _ in bag)\n"
        "print(n, 'messages: peak', peak(), 'MB, before reading', before, 'MB')"
    )
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    print(f"{'memory of reading it':34} {done.stdout.strip()}")


def clock(times: Times, name: str, turn: Turn, verb: str, *arguments: Any) -> Any:
    answer, wall, busy = turn.ask(verb, *arguments)
    times.setdefault((verb, name), []).append(wall)
    times.setdefault((verb + " cpu", name), []).append(busy)
    return answer


def report(label: str, times: Times, verb: str, names: list[str], count: int, size: int) -> None:
    ours = times[verb, "ours"]
    best = statistics.median(ours)
    speed = (
        f"{best * 1000:.1f} ms"
        if count == 1
        else f"{count / best / 1000:.0f} k/s"
        if size < count * 1000
        else f"{size / best / 1e6:.0f} MB/s"
    )
    cells = [f"cpu {statistics.median(times[verb + ' cpu', 'ours']) / best:.2f}"]
    for name in names[1:]:
        each = sorted(t / o for t, o in zip(times[verb, name], ours, strict=True))
        ratio = statistics.median(times[verb, name]) / best
        busy = statistics.median(times[verb + " cpu", name]) / statistics.median(times[verb + " cpu", "ours"])
        cells.append(f"{name} {ratio:.2f}x [{each[0]:.2f}-{each[-1]:.2f}] cpu {busy:.2f}x")
    print(f"{label:34} {speed:>12}  {'; '.join(cells)}", flush=True)


def _bytes(entries: list[Entry]) -> int:
    sizes = {id(message): len(encode(message)) for _, message, _ in entries}
    return sum(sizes[id(message)] for _, message, _ in entries)
