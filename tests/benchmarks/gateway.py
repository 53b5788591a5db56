"""What a rosbridge server costs, beside rosbridge_suite on Debian's rospy in the same run.

    python -m tests.benchmarks gateway [--clients 20] [--seconds 8] [--rounds 2] [--connects 1000]
                                       [--only odometry,image,map,stuck,connects] [--rosbridge-suite PATH]

* odometry: Odometry at 50 Hz, as JSON, to N clients: processor time of the server for a delivered message.
* image: 640x480 rgb8 at 30 Hz as cbor-raw to one client: messages that did not arrive, by their numbers.
* map: a 4000x4000 OccupancyGrid, in each of --compressions, to one client, while another one gets Odometry: its
  longest pause.
* stuck: a cloud of 20 MB/s as cbor-raw to one client that reads and one that has stopped: memory that the server
  grew by, and the 99th percentile of Odometry's way to a third one.
* connects: as many clients one after the other, subscribed and gone without a word: threads, files and subscriptions
  afterwards.

PATH is a checkout of rosbridge_suite, branch ros1; without it only ours is measured. The server is a process of its
own in both cases, so is the publisher, and so is the client whose pauses and latencies are measured: they are not those
of a client that reads something else. The other clients are this process.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple
from xmlrpc.client import ServerProxy

from rosproto import Master, Node
from tests.benchmarks._figures import print_ratio, ratios, spread

ROWS = ("odometry", "image", "map", "stuck", "connects")
TICKS = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100


class Server(NamedTuple):
    name: str
    url: str
    pid: int

    @property
    def processor(self) -> float:
        """Seconds of processor time so far."""
        fields = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / TICKS

    def status(self, name: str) -> int:
        found = re.search(rf"^{name}:\s+(\d+)", Path(f"/proc/{self.pid}/status").read_text(), re.MULTILINE)
        assert found
        return int(found[1])

    @property
    def files(self) -> int:
        return len(os.listdir(f"/proc/{self.pid}/fd"))


def run(arguments: list[str]) -> None:
    if arguments[:1] == ["publish"]:
        publish(*arguments[1:])
        return
    parser = argparse.ArgumentParser(prog="tests.benchmarks gateway")
    parser.add_argument("--clients", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--connects", type=int, default=1000)
    parser.add_argument("--compressions", default="none,cbor,png")
    parser.add_argument("--only", default=",".join(ROWS))
    parser.add_argument("--rosbridge-suite", type=Path)
    args = parser.parse_args(arguments)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        master = stack.enter_context(Master())
        servers = [stack.enter_context(ours(master.uri))]
        if args.rosbridge_suite is not None:
            servers.append(stack.enter_context(theirs(args.rosbridge_suite.resolve(), folder, master.uri)))
        for row in args.only.split(","):
            print(f"\n{row}")
            globals()[f"row_{row}"](args, servers, master.uri)


@contextmanager
def ours(master_uri: str) -> Iterator[Server]:
    words = [sys.executable, "-m", "rosproto", "bridge", "--port", "0", "--master", master_uri]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield Server("rosproto bridge", process.stdout.readline().split()[3], process.pid)
        finally:
            process.terminate()
            process.wait(10)


@contextmanager
def theirs(place: Path, folder: Path, master_uri: str) -> Iterator[Server]:
    from tests.support import ros, rosbridge_suite

    built = rosbridge_suite.build(place, folder / "suite")
    definitions, messages = folder / "definitions", folder / "messages"
    for package in ("nav_msgs", "actionlib_msgs"):
        shutil.copytree(ros.MSGDEFS / package / "msg", definitions / package / "msg")
    ros.generate_python_packages(messages, definitions)
    with rosbridge_suite.served(place, built, master_uri, messages=messages) as url:
        port = url.rpartition(":")[2]
        (pid,) = [
            int(entry)
            for entry in os.listdir("/proc")
            if entry.isdigit() and _is_suite(Path(f"/proc/{entry}/cmdline"), port)
        ]
        yield Server("rosbridge_suite", url, pid)


def _is_suite(cmdline: Path, port: str) -> bool:
    try:
        words = cmdline.read_bytes().decode("utf-8", "replace").split("\0")
    except OSError:
        return False
    return port in words and any(word.endswith("rosbridge_websocket.py") for word in words)


# -- the publisher's process ----------------------------------------------------------------------------------


def publish(master_uri: str, *kinds: str) -> None:
    """Publish until killed: "odom", "image", "cloud", "map"."""
    with (
        Node("/benchmark_publisher", master_uri=master_uri, intraprocess=False) as node,
        ExitStack() as stack,
    ):
        steps = [stack.enter_context(_Stream(node, kind)) for kind in kinds]
        began = time.perf_counter()
        while True:
            due = min(steps, key=lambda step: step.next)
            time.sleep(max(0.0, due.next - (time.perf_counter() - began)))
            due.send()


class _Stream:
    def __init__(self, node: Node, kind: str) -> None:
        import numpy as np

        from rosproto import message_class

        types = {"odom": "nav_msgs/Odometry", "image": "sensor_msgs/Image", "map": "nav_msgs/OccupancyGrid"}
        self.message: Any = message_class(types.get(kind, "sensor_msgs/PointCloud2"))()
        self.every = {"odom": 1 / 50, "image": 1 / 30, "cloud": 1 / 10, "map": 3600.0}[kind]
        self.next = 0.0
        if kind == "image":
            self.message.height, self.message.width, self.message.step = 480, 640, 1920
            self.message.encoding, self.message.data = "rgb8", np.zeros(480 * 640 * 3, np.uint8)
        if kind == "cloud":
            self.message.data = np.zeros(2_000_000, np.uint8)
        if kind == "map":
            self.message.info.width = self.message.info.height = 4000
            cells = np.random.default_rng(1).choice(np.array([-1, 0, 100], np.int8), 16_000_000)
            self.message.data = cells
        self.publisher = node.publisher(f"/{kind}", type(self.message), latch=kind == "map", queue_size=100)

    def __enter__(self) -> _Stream:
        return self

    def __exit__(self, *_: object) -> None:
        self.publisher.close()

    def send(self) -> None:
        from rosproto import Time

        self.next += self.every
        self.message.header.stamp = Time(*divmod(time.time_ns(), 1_000_000_000))
        self.publisher.publish(self.message)


@contextmanager
def published(master_uri: str, *kinds: str) -> Iterator[None]:
    words = [sys.executable, "-m", "tests.benchmarks", "gateway", "publish", master_uri, *kinds]
    process = subprocess.Popen(words)
    try:
        yield
    finally:
        process.kill()
        process.wait(10)


# -- clients ---------------------------------------------------------------------------------------------------


async def connected(server: Server) -> Any:
    from websockets.asyncio.client import connect

    return await connect(server.url, max_size=None, compression=None, ping_interval=None, close_timeout=1)


async def subscribed(server: Server, topic: str, **options: Any) -> Any:
    client = await connected(server)
    await client.send(json.dumps({"op": "subscribe", "topic": topic, **options}))
    return client


async def each(client: Any, take: Callable[[Any], object]) -> None:
    """Hand every message to a function, for ever."""
    async for data in client:
        take(data)


async def during(seconds: float, *tasks: Any) -> None:
    """Let readers run so long."""
    running = [asyncio.ensure_future(task) for task in tasks]
    await asyncio.sleep(seconds)
    for task in running:
        task.cancel()
    await asyncio.gather(*running, return_exceptions=True)


class Watch(NamedTuple):
    """What a client of its own process saw of Odometry."""

    longest_pause: float  # milliseconds
    latencies: list[float]


class Watcher:
    """A process that gets Odometry, and nothing else, while it is used in a `with` block.

    Args:
        program: What it runs: `THROUGH_A_SERVER`, or `AS_A_NODE` for what the way takes without one.
        where: The server's URL, or the master's.
    """

    def __init__(self, program: str, where: str) -> None:
        words = [sys.executable, "-c", program + _WATCHER, where]
        self._process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def __enter__(self) -> Watcher:
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "ready\n"
        return self

    def begin(self) -> None:
        """Forget what was so far."""
        assert self._process.stdin is not None
        self._process.stdin.write("begin\n")
        self._process.stdin.flush()

    def end(self) -> Watch:
        """What was since then."""
        out, _ = self._process.communicate(timeout=20)
        return Watch(**json.loads(out))

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait(10)


THROUGH_A_SERVER = """
import asyncio, json, sys
from websockets.asyncio.client import connect

loop = asyncio.new_event_loop()

async def open():
    client = await connect(sys.argv[1], max_size=None, compression=None, ping_interval=None)
    await client.send(json.dumps({"op": "subscribe", "topic": "/odom", "type": "nav_msgs/Odometry"}))
    return client

client = loop.run_until_complete(open())

def get():
    stamp = json.loads(loop.run_until_complete(client.recv()))["msg"]["header"]["stamp"]
    return stamp["secs"] + stamp["nsecs"] / 1e9
"""
AS_A_NODE = """
import sys
from rosproto import Node

node = Node("/watcher", master_uri=sys.argv[1])
subscriber = node.subscriber("/odom", "nav_msgs/Odometry")

def get():
    return subscriber.next(60).header.stamp.to_sec()
"""
_WATCHER = """
import json, os, threading, time

times, latencies, ended = [], [], threading.Event()

def control():
    for line in sys.stdin:
        times.clear(), latencies.clear()
    ended.set()

get()
threading.Thread(target=control, daemon=True).start()
print("ready", flush=True)
while not ended.is_set():
    stamp = get()
    latencies.append((time.time() - stamp) * 1000)
    times.append(time.perf_counter())
pauses = [1000 * (b - a) for a, b in zip(times, times[1:])]
print(json.dumps({"longest_pause": max(pauses), "latencies": latencies}), flush=True)
os._exit(0)
"""


def percentile(values: list[float], part: float) -> float:
    return sorted(values)[min(len(values) - 1, int(part * len(values)))] if values else float("nan")


def beside(
    args: Any, servers: list[Server], measure: Callable[[Server], float], unit: str
) -> list[list[float]]:
    """One figure of each server in every round; printed."""
    found: list[list[float]] = [[] for _ in servers]
    for _ in range(args.rounds):
        for server, values in zip(servers, found, strict=True):
            values.append(measure(server))
    for server, values in zip(servers, found, strict=True):
        print(f"  {server.name:18} {spread(values)} {unit}")
    return found


# -- rows ------------------------------------------------------------------------------------------------------


def row_odometry(args: Any, servers: list[Server], master_uri: str) -> None:
    async def measured(server: Server) -> float:
        counts = [0] * args.clients

        def counter(number: int) -> Callable[[Any], None]:
            def count(_: Any) -> None:
                counts[number] += 1

            return count

        clients = [await subscribed(server, "/odom", type="nav_msgs/Odometry") for _ in range(args.clients)]
        readers = [each(client, counter(number)) for number, client in enumerate(clients)]
        running = [asyncio.ensure_future(reader) for reader in readers]
        await asyncio.sleep(1.5)
        before, counted = server.processor, sum(counts)
        await asyncio.sleep(args.seconds)
        used, delivered = server.processor - before, sum(counts) - counted
        for task in running:
            task.cancel()
        await asyncio.gather(*running, return_exceptions=True)
        for client in clients:
            await client.close()
        print(
            f"    {server.name}: {delivered} delivered of {50 * args.seconds * args.clients:.0f}, {used:.2f} s"
        )
        # One that delivers less does less: its figure would compare nothing.
        return 1e6 * used / delivered if delivered > 25 * args.seconds * args.clients else float("nan")

    with published(master_uri, "odom"):
        found = beside(
            args, servers, lambda s: asyncio.run(measured(s)), "us of processor a message and client"
        )
    if any(value != value for values in found for value in values):
        print("  NO  no ratio: a server delivered less than half of the messages in a round (nan)")
    elif len(found) == 2:
        print_ratio("of theirs", ratios(*found), 1 / 2, more=False)


def row_image(args: Any, servers: list[Server], master_uri: str) -> None:
    async def measured(server: Server) -> float:
        numbers: list[int] = []

        def note(data: Any) -> None:
            at = data.index(b"bytes") + 5
            at += 5 if data[at] == 0x5A else 9  # a byte string with four or eight bytes of length
            numbers.append(int.from_bytes(data[at : at + 4], "little"))

        client = await subscribed(server, "/image", type="sensor_msgs/Image", compression="cbor-raw")
        await during(1.0, each(client, note))
        numbers.clear()
        before = server.processor
        await during(args.seconds, each(client, note))
        used = server.processor - before
        await client.close()
        missed = numbers[-1] - numbers[0] + 1 - len(numbers) if numbers else -1
        print(f"    {server.name}: {len(numbers)} images, {used:.2f} s of processor")
        return float(missed)

    with published(master_uri, "image"):
        beside(args, servers, lambda s: asyncio.run(measured(s)), "images missed")


def row_map(args: Any, servers: list[Server], master_uri: str) -> None:
    without: list[float] = []

    def measured(server: Server, compression: str) -> float:
        with Watcher(THROUGH_A_SERVER, server.url) as watcher, Watcher(AS_A_NODE, master_uri) as node:
            time.sleep(1.0)
            watcher.begin()
            node.begin()
            words = [sys.executable, "-c", _MAP_CLIENT, server.url, compression]
            began = time.perf_counter()
            try:
                done = subprocess.run(words, capture_output=True, text=True, timeout=150, check=True)
                took = f"{int(done.stdout) / 1e6:.1f} MB after {time.perf_counter() - began:.1f} s"
            except subprocess.TimeoutExpired:
                took = "not within 150 s"
            except subprocess.CalledProcessError as error:
                took = f"never: {error.stderr.strip().splitlines()[-1][:100]}"
            seen, bare = watcher.end(), node.end()
            without.append(bare.longest_pause)
            print(
                f"    {server.name}: the map as {compression} came {took};"
                f" longest pause meanwhile without a server {bare.longest_pause:.0f} ms"
            )
            return seen.longest_pause

    with published(master_uri, "map", "odom"):
        time.sleep(3)
        for compression in args.compressions.split(","):
            print(f"  {compression}")
            without.clear()
            beside(
                args,
                servers,
                lambda server, compression=compression: measured(server, compression),
                "ms longest pause of Odometry (must be < 200 + 20)",
            )
            print(f"  {'without a server':18} {spread(without)} ms: the machine, and the publisher")


_MAP_CLIENT = """
import json, sys
from websockets.sync.client import connect
with connect(sys.argv[1], max_size=None, compression=None, ping_interval=None) as client:
    request = {"op": "subscribe", "topic": "/map", "type": "nav_msgs/OccupancyGrid", "compression": sys.argv[2]}
    client.send(json.dumps(request))
    print(len(client.recv(timeout=140)))
"""


def row_stuck(args: Any, servers: list[Server], master_uri: str) -> None:
    grown: dict[str, list[float]] = {}
    without: list[float] = []

    async def measured(server: Server, watcher: Watcher, node: Watcher) -> float:
        clouds: list[int] = []
        cloud = {"type": "sensor_msgs/PointCloud2", "compression": "cbor-raw"}
        reading = await subscribed(server, "/cloud", **cloud)
        reader = asyncio.ensure_future(each(reading, lambda data: clouds.append(len(data))))
        await asyncio.sleep(2.0)
        clouds.clear()
        before, used = server.status("VmRSS"), server.processor
        stuck = await subscribed(server, "/cloud", **cloud)
        stuck.transport.pause_reading()
        for each_watcher in (watcher, node):
            each_watcher.begin()
        peak = 0
        for _ in range(int(args.seconds * 4)):
            await asyncio.sleep(0.25)
            peak = max(peak, server.status("VmRSS"))
        used = server.processor - used
        latencies = await asyncio.to_thread(watcher.end)
        bare = await asyncio.to_thread(node.end)
        reader.cancel()
        await asyncio.gather(reader, return_exceptions=True)
        grown.setdefault(server.name, []).append((peak - before) / 1024)
        without.append(percentile(bare.latencies, 0.99))
        print(
            f"    {server.name}: {len(clouds)} clouds to the one that reads, of {10 * args.seconds:.0f};"
            f" {used:.2f} s of processor; Odometry's p99 meanwhile without a server {without[-1]:.1f} ms"
        )
        stuck.transport.abort()
        await reading.close()
        return percentile(latencies.latencies, 0.99)

    def watched(server: Server) -> float:
        with Watcher(THROUGH_A_SERVER, server.url) as watcher, Watcher(AS_A_NODE, master_uri) as node:
            return asyncio.run(measured(server, watcher, node))

    with published(master_uri, "cloud", "odom"):
        beside(args, servers, watched, "ms, 99th percentile of Odometry (must be < 50)")
    print(f"  {'without a server':18} {spread(without)} ms: the machine, and the publisher")
    for name, values in grown.items():
        print(f"  {name:18} {spread(values)} MB more memory (must be < 64)")


def row_connects(args: Any, servers: list[Server], master_uri: str) -> None:
    async def come_and_go(server: Server, count: int) -> None:
        for _ in range(count):
            client = await subscribed(server, "/odom", type="nav_msgs/Odometry")
            client.transport.abort()
            await asyncio.sleep(0)

    def subscribers() -> int:
        state = ServerProxy(master_uri).getSystemState("/benchmark")
        return sum(len(nodes) for topic, nodes in state[2][1] if topic == "/odom")

    with published(master_uri, "odom"):
        for server in servers:
            asyncio.run(come_and_go(server, 20))
            time.sleep(4)
            before = server.status("Threads"), server.files
            began = time.perf_counter()
            asyncio.run(come_and_go(server, args.connects))
            took = time.perf_counter() - began
            time.sleep(15)  # idle threads of the pool end after ten
            after = server.status("Threads"), server.files
            print(
                f"  {server.name:18} {args.connects} clients in {took:.1f} s; threads {before[0]} -> {after[0]},"
                f" files {before[1]} -> {after[1]}; {subscribers()} subscribers of the topic are left"
            )
