"""What the Robot API costs: a message of its server beside rosbridge's, and a robot that answers slowly or wrongly.

    python -m tests.benchmarks robot_api [--rounds 5] [--requests 2000] [--clients 20] [--seconds 8]
                                         [--only requests,pushes,crowd,start,verbs]

* requests: processor time of the server for a question with its answer: by POST on a kept connection, by WebSocket,
  and of rosbridge a call of /rosapi/get_time, which its server answers itself.
* pushes: the pose at 50 Hz to N clients, ten a second to each: processor time of the server for a delivered message.
* crowd: 2,000 connections at once, of each kind in tests/scenarios/test_robot_api_http.py: memory that the server
  grew by, and the longest answer to a client by WebSocket and one by HTTP meanwhile.
* start: until a new `Chassis` has its first pose, with and without `robot_api`, for each kind of robot.
* verbs: what `stop`, a short `move` with its end, and a second of a drive back take, and the processor time of the
  program meanwhile, while `readiness` is asked ten times a second, for each kind of robot.

A kind of robot is how its Robot API answers: "off" is not asked; "late" answers after 5 s; "silent" never; "endless"
with a body without end; "half" with half of one; "other" with another schema. Server, robot, its Robot API and the
clients of a server are processes of their own. The rounds are interleaved.
"""

from __future__ import annotations

import argparse
import http.client
import itertools
import json
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress

from rosproto import Master, Node
from tests.benchmarks._figures import print_ratio, ratios, spread
from tests.benchmarks.gateway import Server, during, each, ours
from woosh_pure import Chassis

ROWS = ("requests", "pushes", "crowd", "start", "verbs")
ROBOTS = ("off", "good", "late", "silent", "endless", "half", "other")
_SERVER = """
import sys
from rosproto import Node
from woosh_pure.api_server import RobotApiServer
with Node("/api", master_uri=sys.argv[1], rosout=False) as node, RobotApiServer(node, port=0) as server:
    print(server.url, flush=True)
    sys.stdin.read()
"""
_SIM = """
import sys
from woosh_pure import SimulatedChassis
with SimulatedChassis(full_graph=False, speed=4.0) as sim:
    print(sim.master_uri, flush=True)
    sys.stdin.read()
"""
_PEER = """
import sys, time
from tests.support.robot_api_peer import ANSWERS, ApiPeer, endless, half, silent
STATE = "woosh.robot.RobotState"
kind = sys.argv[1]
lies = {"silent": silent, "endless": endless, "half": half, "other": {"state": {"text": []}}}
answers = {**ANSWERS, STATE: lies[kind]} if kind in lies else ANSWERS
with ApiPeer(answers, wait=(lambda request: time.sleep(5.0)) if kind == "late" else str) as peer:
    print(peer.address, flush=True)
    sys.stdin.read()
"""


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks robot_api")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--requests", type=int, default=2000)
    parser.add_argument("--clients", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--only", default=",".join(ROWS))
    args = parser.parse_args(arguments)
    for row in args.only.split(","):
        print(f"\n{row}")
        globals()[f"row_{row}"](args)


@contextmanager
def child(program: str, *words: str) -> Iterator[tuple[str, int]]:
    """A process until the end of the block: the line that it printed, and its number."""
    with subprocess.Popen(
        [sys.executable, "-c", program, *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip(), process.pid
        finally:
            process.stdin.close()
            process.wait(20)


# -- the server ------------------------------------------------------------------------------------------------


@contextmanager
def served() -> Iterator[tuple[Server, Server, Node]]:
    """Both servers over one graph, and a node that plays the robot."""
    with ExitStack() as stack:
        master = stack.enter_context(Master())
        robot = stack.enter_context(Node("/robot", master_uri=master.uri, intraprocess=False, rosout=False))
        battery = stack.enter_context(robot.publisher("/battery", "woosh_msgs/Battery", latch=True))
        battery.publish(batteryPercentage=80)
        url, pid = stack.enter_context(child(_SERVER, master.uri))
        yield Server("robot-api", url, pid), stack.enter_context(ours(master.uri)), robot


def row_requests(args: argparse.Namespace) -> None:
    from websockets.sync.client import connect

    found: dict[str, list[float]] = {}
    with served() as (api, bridge, _):
        posts = http.client.HTTPConnection("127.0.0.1", int(api.url.rpartition(":")[2]))

        def post(number: int) -> None:
            posts.request("POST", "/woosh/robot/Battery", "{}")
            assert json.loads(posts.getresponse().read())["ok"]

        with connect(api.url, compression=None) as socket, connect(bridge.url, compression=None) as other:

            def ask(number: int) -> None:
                socket.send(json.dumps({"type": "woosh.robot.Battery", "body": {}, "sn": number}))
                assert json.loads(socket.recv())["ok"]

            def call(number: int) -> None:
                other.send(
                    json.dumps({"op": "call_service", "service": "/rosapi/get_time", "id": str(number)})
                )
                assert json.loads(other.recv())["result"]

            ways: dict[str, tuple[Server, Callable[[int], None]]] = {
                "POST": (api, post), "WebSocket": (api, ask), "rosbridge call": (bridge, call),
            }  # fmt: skip
            for _, (label, (server, way)) in itertools.product(range(args.rounds), ways.items()):
                before = server.processor
                for number in range(args.requests):
                    way(number)
                found.setdefault(label, []).append(1e6 * (server.processor - before) / args.requests)
        posts.close()
    for label, values in found.items():
        print(f"  {label:24} {spread(values)} us of processor time a question")
    for label in ("POST", "WebSocket"):
        print_ratio(
            f"{label} / rosbridge call", ratios(found[label], found["rosbridge call"]), 1.5, more=False
        )


def row_pushes(args: argparse.Namespace) -> None:
    import asyncio

    found: dict[str, list[float]] = {}

    async def measure(server: Server, frame: dict[str, object]) -> float:
        from websockets.asyncio.client import connect

        clients = [await connect(server.url, compression=None) for _ in range(args.clients)]
        for client in clients:
            await client.send(json.dumps(frame))
        got = [0]

        def take(data: object) -> None:
            got[0] += 1

        await during(1.0, *(each(client, take) for client in clients))
        got[0], before = 0, server.processor
        await during(args.seconds, *(each(client, take) for client in clients))
        spent = server.processor - before
        for client in clients:
            await client.close()
        return 1e6 * spent / max(1, got[0])

    with served() as (api, bridge, robot), ExitStack() as stack:
        pose = stack.enter_context(robot.publisher("/movebase_pose2d", "geometry_msgs/Pose2D"))
        twist = stack.enter_context(robot.publisher("/odom_twist", "geometry_msgs/Twist"))
        over = threading.Event()

        def drive() -> None:
            for step in itertools.count():
                pose.publish(x=0.01 * step)
                twist.publish()
                if over.wait(0.02):
                    return

        thread = threading.Thread(target=drive)
        thread.start()
        topic = {"op": "subscribe", "topic": "/movebase_pose2d", "throttle_rate": 100, "queue_length": 1}
        topics = {"sub": True, "topics": ["woosh.robot.PoseSpeed"]}
        try:
            for _ in range(args.rounds):
                for server, frame in ((api, {"type": "woosh.Subscription", "body": topics}), (bridge, topic)):
                    found.setdefault(server.name, []).append(asyncio.run(measure(server, frame)))
        finally:
            over.set()
            thread.join()
    for label, values in found.items():
        print(f"  {label:24} {spread(values)} us of processor time a delivered pose")
    print_ratio("Robot API / rosbridge", ratios(*found.values()), 2.0, more=False)


def row_crowd(args: argparse.Namespace) -> None:
    from tests.scenarios.test_robot_api_http import CROWDS

    for kind, sent in CROWDS.items():
        grown, longest = [], []
        for _ in range(args.rounds):
            with served() as (api, _, _):
                before = api.status("VmRSS")
                longest.append(1e3 * _longest_answer(api.url, sent))
                grown.append((api.status("VmHWM") - before) / 1024)
        print(f"  {kind:24} {spread(longest)} ms longest answer  {spread(grown)} MB grown")


def _longest_answer(url: str, sent: Callable[[int], bytes]) -> float:
    from websockets.sync.client import connect

    port, over, longest = int(url.rpartition(":")[2]), threading.Event(), [0.0]

    def ask() -> None:
        while not over.wait(0.02):
            began = time.monotonic()
            client.send(json.dumps({"type": "woosh.robot.Battery"}))
            assert json.loads(client.recv(60.0))["ok"]
            posts = http.client.HTTPConnection("127.0.0.1", port, timeout=60.0)
            with closing(posts), suppress(ConnectionError, http.client.HTTPException):
                posts.request("POST", "/woosh/robot/Battery", "{}")
                posts.getresponse().read()
            longest[0] = max(longest[0], time.monotonic() - began)

    thread = threading.Thread(target=ask)
    with connect(url, compression=None) as client, ExitStack() as stack:
        thread.start()
        try:
            for number in range(2000):
                sock = stack.enter_context(socket.create_connection(("127.0.0.1", port), 60.0))
                sock.setblocking(False)
                with suppress(OSError):
                    sock.sendall(sent(number))
            time.sleep(1.0)
        finally:
            over.set()
            thread.join()
    return longest[0]


# -- the robot -------------------------------------------------------------------------------------------------


@contextmanager
def robots() -> Iterator[tuple[str, dict[str, str | bool]]]:
    """The master of a simulated robot, and what `robot_api` is for each kind."""
    with ExitStack() as stack:
        kinds: dict[str, str | bool] = {"off": False}
        for kind in ROBOTS[1:]:
            kinds[kind] = stack.enter_context(child(_PEER, kind))[0]
        yield stack.enter_context(child(_SIM))[0], kinds


def row_start(args: argparse.Namespace) -> None:
    found: dict[str, list[float]] = {}
    with robots() as (master_uri, kinds):
        for _, (kind, given) in itertools.product(range(args.rounds), kinds.items()):
            began = time.perf_counter()
            with Chassis(master_uri, robot_api=given) as chassis:
                chassis.pose.wait(20.0)
                found.setdefault(kind, []).append(1e3 * (time.perf_counter() - began))
    for kind, values in found.items():
        print(f"  {kind:24} {spread(values)} ms to the first pose")
    for kind in ROBOTS[1:]:
        print_ratio(f"{kind} / off", ratios(found[kind], found["off"]), 1.1, more=False)


def row_verbs(args: argparse.Namespace) -> None:
    found: dict[str, dict[str, list[float]]] = {}
    with robots() as (master_uri, kinds):
        for _, (kind, given) in itertools.product(range(args.rounds), kinds.items()):
            row = found.setdefault(kind, {"stop": [], "move": [], "drive": [], "processor": []})
            with Chassis(master_uri, robot_api=given) as chassis:
                chassis.pose.wait(20.0)
                over = threading.Event()

                def poll(chassis: Chassis = chassis, over: threading.Event = over) -> None:
                    while not over.wait(0.1):
                        chassis.readiness()

                thread = threading.Thread(target=poll)
                thread.start()
                spent = time.process_time()
                try:
                    for name, verb in (
                        ("move", lambda: chassis.move(0.4).wait(timeout=60.0)),  # and back by the drive
                        ("drive", lambda: _drive(chassis, -0.1)),
                        ("stop", chassis.stop),
                    ):
                        began = time.perf_counter()
                        verb()
                        row[name].append(1e3 * (time.perf_counter() - began))
                finally:
                    over.set()
                    thread.join()
                row["processor"].append(1e3 * (time.process_time() - spent))
    for name in ("move", "drive", "stop", "processor"):
        for kind in ROBOTS:
            print(f"  {name:10} {kind:13} {spread(found[kind][name])} ms")
        for kind in ROBOTS[1:]:
            print_ratio(
                f"{name}: {kind} / off", ratios(found[kind][name], found["off"][name]), 1.15, more=False
            )


def _drive(chassis: Chassis, speed: float) -> None:
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.hold(speed, seconds=1.0)
