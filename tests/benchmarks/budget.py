"""Where the microseconds of a small message go: `python -m tests.benchmarks budget [--rounds 7] [--count 20000]`.

From `publish` to the socket and from the socket to the callback, by TCP over loopback. Each stage is measured alone,
all of them in every round, and printed as the median of the rounds with the spread:

* publish: everything but the system call: the socket is one that takes nothing (`Null`).
* send, read: the system calls, on a socket whose other end does not wait, or has the message there already.
* send, waking: the same system call when a reader waits in another process.
* read to callback: everything but the system call: messages come from memory.
* thread to thread: what a program adds that waits in another thread than the callback's.

Then the system calls of a node that answers pings, counted by strace where it is installed: those of a long run less
those of a short one. The way between two processes as a whole, beside rospy, roscpp and bare sockets, is measured by
`transport --only ping,steady`.
"""

from __future__ import annotations

import argparse
import re
import shutil
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

from rosproto import Node, message_class
from rosproto.codec import decoder
from rosproto.errors import ConnectionLost
from rosproto.master import Master
from rosproto.node.incoming.subscriber_queue import CallbackRunner, Inbox
from rosproto.node.incoming.tcpros_link import FrameReader
from tests.benchmarks._figures import spread
from tests.benchmarks.transport import Bench

READER = """
import socket, sys
s = socket.create_connection(("127.0.0.1", int(sys.argv[1])))
buffer = bytearray(4096)
while s.recv_into(buffer):
    pass
"""


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks budget")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--count", type=int, default=20_000, help="messages of a round")
    args = parser.parse_args(arguments)
    stages: dict[str, Callable[[int], float]] = {
        "publish, without the system call": publishing,
        "send": sending,
        "send, waking a reader": lambda count: waking(count // 10),
        "read": reading,
        "read to callback, without the system call": calling,
        "thread to thread": lambda count: handing_over(count // 10),
    }
    times: dict[str, list[float]] = {name: [] for name in stages}
    for _ in range(args.rounds):
        for name, measure in stages.items():
            times[name].append(measure(args.count) * 1e6)
    print(f"a Twist on Python {sys.version.split()[0]}: microseconds")
    for name, values in times.items():
        print(f"  {name:42} {spread(values)}")
    if shutil.which("strace"):
        count_system_calls()


class Null:
    """A socket that takes everything and gives one message again and again, without a system call."""

    def __init__(self, frame: bytes, count: int) -> None:
        self._frame, self._left = frame, count

    def send(self, data: bytes) -> int:
        return len(data)

    def recv_into(self, buffer: Any, size: int = 0, flags: int = 0) -> int:
        if not self._left:
            return 0
        self._left -= 1
        return len(self._frame)  # it is in the buffer already


def a_frame() -> tuple[type, bytes]:
    cls = message_class("geometry_msgs/Twist")
    return cls, (48).to_bytes(4, "little") + bytes(48)


def publishing(count: int) -> float:
    """Seconds of one `publish` to one subscriber, its `send` left out."""
    cls, _ = a_frame()
    with (
        Master() as master,
        Node("/out", master_uri=master.uri, intraprocess=False) as out,
        Node("/in", master_uri=master.uri, intraprocess=False) as other,
    ):
        there = threading.Event()
        other.subscriber("/t", cls, lambda message: there.set())
        publisher = out.publisher("/t", cls)
        publisher.wait_for_connection(10)
        publisher.publish(cls())
        there.wait(10)
        link: Any = publisher._publication.links[0]
        real, link.sock = link.sock, Null(b"", 0)
        message, publish = cls(), publisher.publish
        try:
            took = 0.0
            for _ in range(count):
                publisher._publication._returned = 0.0  # one by one, not a burst
                began = perf_counter()
                publish(message)
                took += perf_counter() - began
        finally:
            link.sock = real
    return took / count - clock()


def clock() -> float:
    """What asking for the time adds to each measurement."""
    took = 0.0
    for _ in range(10_000):
        began = perf_counter()
        took += perf_counter() - began
    return took / 10_000


def connected() -> tuple[socket.socket, socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        near = socket.create_connection(server.getsockname())
        far, _ = server.accept()
    near.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return near, far


def sending(count: int) -> float:
    """Seconds of `send` when nobody waits at the other end."""
    near, far = connected()
    data, took = a_frame()[1], 0.0
    with near, far:
        for _ in range(count):
            began = perf_counter()
            near.send(data)
            took += perf_counter() - began
            far.recv(4096)
    return took / count - clock()


def reading(count: int) -> float:
    """Seconds of a read when the message is there."""
    near, far = connected()
    data, buffer, took = a_frame()[1], bytearray(4096), 0.0
    with near, far:
        for _ in range(count):
            near.send(data)
            began = perf_counter()
            far.recv_into(buffer)
            took += perf_counter() - began
    return took / count - clock()


def waking(count: int) -> float:
    """Seconds of `send` when another process waits for it, 500 us after the last one."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        reader = subprocess.Popen([sys.executable, "-c", READER, str(server.getsockname()[1])])
        near, _ = server.accept()
    near.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    data, times, pause = a_frame()[1], [], threading.Event()
    with near:
        for _ in range(count):
            pause.wait(500e-6)
            began = perf_counter()
            near.send(data)
            times.append(perf_counter() - began)
    reader.wait(10)
    return statistics.median(times) - clock()


def calling(count: int) -> float:
    """Seconds from the end of a read to that of a callback that does nothing."""
    cls, frame = a_frame()
    decode = decoder(cls)
    reader = FrameReader(Null(frame, count), 1 << 30)  # type: ignore[arg-type]
    reader._no_rest_until = float("inf")
    reader._frames.buffer[: len(frame)] = frame
    runner = CallbackRunner(lambda message: None, Inbox(10), "/t")
    began = perf_counter()
    try:
        while True:
            (message,) = reader.receive(decode, False)
            message._connection_header = {}
            runner.offer_one(message)
    except ConnectionLost:
        pass
    took = perf_counter() - began
    null = Null(frame, count).recv_into
    began = perf_counter()
    for _ in range(count):
        null(None)
    return (took - (perf_counter() - began)) / count


def handing_over(count: int) -> float:
    """Seconds from `Event.set` in one thread to the end of `wait` in another."""
    there, back, times, sent = threading.Event(), threading.Event(), [], [0.0]

    def wait() -> None:
        for _ in range(count):
            there.wait(10)
            times.append(perf_counter() - sent[0])
            there.clear()
            back.set()

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    for _ in range(count):
        sent[0] = perf_counter()
        there.set()
        back.wait(10)
        back.clear()
    thread.join(10)
    return statistics.median(times)


def count_system_calls() -> None:
    """Of a node that answers pings from its callback, for one ping."""
    print("system calls of a node that answers pings, for one ping (strace -f -c)")
    with tempfile.TemporaryDirectory() as folder, Bench(Path(folder), 1, 1.0) as bench:
        for lib in ("ours", "rospy", "bare"):
            long, short = (traced(bench, lib, count) for count in (2200, 200))
            calls = {name: (long[name] - short.get(name, 0)) / 2000 for name in long}
            some = {
                name: calls[name] for name in sorted(calls, key=lambda n: -calls[n]) if calls[name] >= 0.02
            }
            print(f"  {lib:10} {', '.join(f'{name} {value:.2f}' for name, value in some.items())}")


def traced(bench: Bench, lib: str, count: int) -> dict[str, int]:
    path = bench.folder / "calls"
    bench.renew()
    second = bench.start(lib, "pong", ["strace", "-f", "-c", "-o", str(path)], life=5 + count / 500)
    first = None
    try:
        first = bench.start(lib, "ping", count=count)
        second.wait(60)  # strace writes what it has counted when the program has ended
    finally:
        for process in filter(None, (first, second)):
            process.kill()
            process.wait(10)
    rows = re.findall(r"^ *[\d.]+ +[\d.]+ +\d+ +(\d+) +(?:\d+ +)?(\w+)$", path.read_text(), re.M)
    return {name: int(calls) for calls, name in rows if name != "total"}
