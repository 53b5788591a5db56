"""What revisions cost: nothing while the md5sums agree, and so much per message when they do not.

First the two ways of a message: publishing to a subscriber that takes everything, and receiving from a connection
that always has more, with a peer of the same definition, and with one of another revision: decoded or encoded in
that, and carried over by field name. Then both end to end over TCP, between two processes.
"""

from __future__ import annotations

import argparse
import json
import logging
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

from rosproto import Master, Node
from rosproto.codec import message_class
from rosproto.node.incoming.tcpros_link import FrameReader, TcprosLink
from rosproto.protocol.framing import frame

TYPES = {
    "geometry_msgs/Twist": "",
    "woosh_msgs/StepControlActionGoal": "1.1.0",
    "woosh_msgs/Battery": "page",
    "woosh_msgs/Information": "page",
}
"""Types, and a revision of each; Twist has none."""


def run(arguments: list[str]) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks negotiation", description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--messages", type=int, default=20_000, help="per round and way")
    parser.add_argument("--part", choices=["paths", "tcp"], help="only this one")
    options = parser.parse_args(arguments)
    logging.disable(logging.WARNING)  # one line for each link that differs
    with Master() as master:
        if options.part != "tcp":
            _paths(master.uri, options)
        if options.part != "paths":
            _over_tcp(master.uri, options)
    return 0


# -- the ways of a message, without a network ------------------------------------------------------------------


class Sink:
    """A subscriber that takes everything at once (an `OutgoingLink`)."""

    id, caller_id, queue_size, transport = 0, "/sink", 10, "NONE"

    def send(self, data: Any) -> None:
        """Take it."""

    def send_soon(self, data: Any, now: float) -> bool:
        """Take it."""
        return False

    send_large = send

    def start(self) -> None:
        """Nothing to start."""

    def stats(self) -> Any:
        """For being detached."""
        return type("Stats", (), {"bytes": 0})

    def close(self) -> None:
        """Nothing to close."""


class Stream:
    """A socket from which the same frames always arrive, until enough were read."""

    def __init__(self, data: bytes, reads: int) -> None:
        self._data, self._reads = memoryview(data), reads
        self._rest = self._data[:0]

    def recv_into(self, view: memoryview, size: int = 0, flags: int = 0) -> int:
        """As much as there is, and room for."""
        if not self._rest:
            if not self._reads:
                return 0
            self._reads -= 1
            self._rest = self._data
        count = min(len(view), len(self._rest))
        view[:count] = self._rest[:count]
        self._rest = self._rest[count:]
        return count


def _paths(uri: str, options: argparse.Namespace) -> None:
    print("nanoseconds of this thread per message: least of the rounds")
    print(f"{'':34s} {'agreeing':>9s} {'differing':>10s} {'ratio':>6s}")
    with Node("/bench", master_uri=uri, rosout=False) as node:
        for name, label in TYPES.items():
            _of_type(node, message_class(name), _revision(name, label), options)


def _of_type(node: Node, ours: Any, theirs: Any, options: argparse.Namespace) -> None:
    """Both ways of one type."""
    taken = node.subscriber("/in", ours, lambda message: None, queue_size=1_000_000)  # all are decoded
    with node.publisher("/out", ours) as handle, taken:
        publication, message = handle._publication, _sample(ours)

        def publishing(cls: Any) -> float:
            output = publication.output_for(_header(cls, "/out"), "peer")
            publication.attach(Sink(), "sink", output)
            took = _time(lambda: _repeat(handle, message, options.messages))
            for link in publication.all_links:
                publication.detach(link)
            publication._revised.clear()
            return took / options.messages

        def receiving(cls: Any) -> float:
            return _receive(taken._subscription, cls, options.messages)

        _row(f"publish {ours._type}", publishing, ours, theirs, options.rounds)
        _row(f"receive {ours._type}", receiving, ours, theirs, options.rounds)


def _row(label: str, measure: Callable[[Any], float], ours: Any, theirs: Any, rounds: int) -> None:
    agreeing, differing = [], []
    for _ in range(rounds):
        agreeing.append(measure(ours))
        if theirs is not None:
            differing.append(measure(theirs))
    other = (
        f"{min(differing):10.0f} {min(differing) / min(agreeing):6.2f}"
        if differing
        else f"{'-':>10s} {'-':>6s}"
    )
    print(f"{label.replace('woosh_msgs/', ''):34s} {min(agreeing):9.0f} {other}", flush=True)


def _repeat(handle: Any, message: Any, count: int) -> None:
    for _ in range(count):
        handle.publish(message)


def _receive(subscription: Any, cls: Any, count: int) -> float:
    """Nanoseconds per message of a link's loop over frames that have arrived."""
    from rosproto.codec import encode

    one = frame(encode(_sample(cls)))
    per_read = max(1, min(64, (128 << 10) // len(one)))
    link: Any = TcprosLink(subscription, "http://127.0.0.1:9/", 1)
    link._reader = FrameReader(Stream(one * per_read, count // per_read), 1 << 20)  # type: ignore[arg-type]
    link.header = {"callerid": "/bench"}
    if cls is not subscription.type.message_class:
        reply = _Reply(cls)
        link._revised = subscription.learn(reply, "peer")

    def work() -> None:
        try:
            link._receive()
        except ConnectionError:
            pass  # all was read

    return _time(work) / (per_read * (count // per_read))


class _Reply:
    """A `PublisherReply` of a class."""

    def __init__(self, cls: Any) -> None:
        self.callerid, self.type_name, self.md5sum = "/bench", cls._type, cls._md5sum
        self.message_definition = cls._full_text


def _time(work: Callable[[], None]) -> float:
    """Nanoseconds of this thread: what others of a busy computer do is not in them."""
    began = time.thread_time_ns()
    work()
    return time.thread_time_ns() - began


def _revision(name: str, label: str) -> Any:
    from rosproto.msg import bundled

    return message_class(name, bundled().package_revisions("woosh_msgs")[label]) if label else None


def _header(cls: Any, topic: str) -> dict[str, str]:
    return {"topic": topic, "type": cls._type, "md5sum": cls._md5sum, "callerid": "/sink"}


def _sample(cls: Any) -> Any:
    message = cls()
    if cls._type == "woosh_msgs/StepControlActionGoal":
        step = message_class("woosh_msgs/StepControl", cls._binding.library)
        message.goal.stepControl = [step(executeMode=1, data=0.5, speed=0.2) for _ in range(3)]
    return message


# -- over TCP ----------------------------------------------------------------------------------------------------

PEER = """
import json, sys, time
from rosproto import Node
from tests.benchmarks.negotiation import _revision, _sample, message_class
uri, name, label, role, count = *sys.argv[1:5], int(sys.argv[5])
cls = _revision(name, label) or message_class(name)
with Node("/peer", master_uri=uri, rosout=False, anonymous=True) as node:
    if role == "publish":
        pub = node.publisher("/burst", cls, queue_size=100000)
        pub.wait_for_connection(timeout=20)
        time.sleep(0.2)
        message = _sample(cls)
        for i in range(count):
            pub.publish(message)
            if i % 2000 == 1999: pub.flush(20)
        pub.flush(20)
        time.sleep(0.5)
    else:
        done, times = 0, []
        def take(m):
            times.append(time.perf_counter())
        sub = node.subscriber("/burst", cls, take, queue_size=100000)
        print("ready", flush=True)
        end = time.monotonic() + 60
        while len(times) < count and time.monotonic() < end: time.sleep(0.02)
        print(json.dumps(len(times) / (times[-1] - times[0]) / 1000))
"""


def _over_tcp(uri: str, options: argparse.Namespace) -> None:
    print("\nk messages/s over TCP, published and received as fast as possible in two processes")
    print(f"{'':34s} {'agreeing':>12s} {'subscriber is older':>20s} {'publisher is older':>20s}")
    for name, label in TYPES.items():
        if not label:
            continue
        rates: dict[tuple[str, str], list[float]] = {("", ""): [], ("", label): [], (label, ""): []}
        for _ in range(max(3, options.rounds // 4)):
            for (publisher, subscriber), values in rates.items():
                values.append(_burst(uri, name, publisher, subscriber, options.messages))
        cells = [f"{statistics.median(values):.1f}" for values in rates.values()]
        print(f"{name.replace('woosh_msgs/', ''):34s} {cells[0]:>12s} {cells[1]:>20s} {cells[2]:>20s}")


def _burst(uri: str, name: str, publisher: str, subscriber: str, count: int) -> float:
    def start(label: str, role: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-c", PEER, uri, name, label, role, str(count)]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)

    taking = start(subscriber, "receive")
    assert taking.stdout is not None
    assert taking.stdout.readline() == "ready\n"
    giving = start(publisher, "publish")
    try:
        said, _ = taking.communicate(timeout=90)
        return float(json.loads(said))
    finally:
        for process in (taking, giving):
            process.kill()
            process.wait(5)
