"""What clients that send all they can cost the others: STOP of the page, zero of a gateway, memory, and the end.

    python -m tests.benchmarks floods [--trials 10] [--clients 1,63] [--only page,deadman,bridge,foxglove] [--what NAME,NAME]
                                      [--tls]

* page: the robot turns, and POST stop is sent beside clients that flood live connections: seconds until it stands still,
  by its odometry, and until the answer.
* deadman: a page drives the robot by hand, and its heartbeats end: seconds until it stands still.
* bridge, foxglove: seconds until another client's zero velocity arrives, beside clients that flood the gateway; memory of the
  server at its peak and five seconds after all floods; seconds from SIGTERM to its end.

`--tls` serves the page over TLS. Each row has the median and the longest of all trials. `--what` names rows of `tests.support.gateway_flood.PAYLOADS`.
"""

from __future__ import annotations

import argparse
import http.client
import json
import signal
import ssl
import statistics
import struct
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path
from typing import Any

from rosproto import Node
from tests.support.certificates import certificate
from tests.support.gateway_flood import Crowd, GatewayProcess, PageProcess
from tests.support.rosbridge_client import RosbridgeClient
from tests.support.viewer import Viewer
from tests.support.web import PageClient
from woosh_pure import Chassis, SimulatedChassis

LATE = 60.0
FRAMES = (
    "messages of 3000 frames",
    "tiny messages",
    "tiny invalid messages",
    "pings",
    "pings of 125 bytes",
    "pongs",
)
LIVE = "/api/v1/live"


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks floods")
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--clients", default="1,63")
    parser.add_argument("--only", default="page,deadman,bridge,foxglove")
    parser.add_argument("--what", default=None)
    parser.add_argument("--tls", action="store_true")
    args = parser.parse_args(arguments)
    clients = [int(number) for number in args.clients.split(",")]
    for part in args.only.split(","):
        what = args.what.split(",") if args.what else [*FRAMES, *(["raw types"] if part == "bridge" else [])]
        print(f"{part}{' over TLS' if args.tls and part in ('page', 'deadman') else ''}:", flush=True)
        if part in ("page", "deadman"):
            page(what, clients, args.trials, args.tls, by_hand=part == "deadman")
        else:
            gateway(part, what, clients, args.trials)


def row(name: str, clients: int, **took: Sequence[float]) -> None:
    figures = ", ".join(
        f"{what} {statistics.median(t):.2f} (longest {max(t):.2f}) s" for what, t in took.items()
    )
    print(f"{name}, {clients} clients, {len(next(iter(took.values())))} trials: {figures}", flush=True)


def page(floods: Sequence[str], clients: Sequence[int], trials: int, tls: bool, *, by_hand: bool) -> None:
    """Time STOP, or the end of a drive by hand."""
    with ExitStack() as stack:
        sim = stack.enter_context(SimulatedChassis(full_graph=False))
        chassis = stack.enter_context(Chassis(sim.master_uri))
        chassis.odometry.wait(timeout=20)
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        server = stack.enter_context(PageProcess(sim.master_uri, certificate(Path(folder)) if tls else None))
        timed: Callable[[str, int], None] = partial(stops, chassis, server, trials, tls)
        if by_hand:
            options = {"ssl": unverified()} if tls else {}
            driver = stack.enter_context(PageClient(server.port, **options))
            driver.of("hello")
            driver.ready()
            timed = partial(releases, chassis, driver, trials)
        timed("none", 0)
        for what in floods:
            for number in clients:
                with Crowd(server.port, what, number, LIVE, tls=tls):
                    timed(what, number)
        print(f"memory: {server.memory() / 1e6:.0f} MB at most", flush=True)


def stops(chassis: Chassis, server: PageProcess, trials: int, tls: bool, what: str, clients: int) -> None:
    stood, answered = [], []
    for _ in range(trials):
        goal = chassis.rotate(60.0, several_turns=True)
        until_turning(chassis, True)
        began = time.monotonic()
        answer = Answer(server.port, tls)
        until_turning(chassis, False)
        stood.append(time.monotonic() - began)
        answered.append(answer.seconds(began))
        goal.cancel()
    row(what, clients, standstill=stood, answer=answered)


def releases(chassis: Chassis, driver: PageClient, trials: int, what: str, clients: int) -> None:
    stood, not_driven = [], 0
    for _ in range(trials):
        driver.hold(0.0, 0.4)
        try:
            until_turning(chassis, True, 5.0)
        except TimeoutError:  # heartbeats were held up, so that the dead man ended the press
            not_driven += 1
        else:
            began = time.monotonic()
            driver.stop_beating()
            until_turning(chassis, False)
            stood.append(time.monotonic() - began)
        driver.let_go()
        time.sleep(0.3)
    row(what, clients, standstill=stood or [LATE])
    print(f"    {not_driven} presses did not drive", flush=True)


def unverified() -> ssl.SSLContext:
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context


def until_turning(chassis: Chassis, turning: bool, seconds: float = LATE) -> None:
    end = time.monotonic() + seconds
    while (abs(chassis.odometry.wait(timeout=LATE).velocity.wz) > 0.01) is not turning:
        if time.monotonic() > end:
            raise TimeoutError(f"the robot {'does not turn' if turning else 'goes on'}")
        time.sleep(0.01)


class Answer:
    """The answer to POST stop, in a thread."""

    def __init__(self, port: int, tls: bool) -> None:
        self._connection: http.client.HTTPConnection = (
            http.client.HTTPSConnection("127.0.0.1", port, timeout=LATE, context=unverified())
            if tls
            else http.client.HTTPConnection("127.0.0.1", port, timeout=LATE)
        )
        self._at = LATE
        self._thread = threading.Thread(target=self._ask, daemon=True)
        self._thread.start()

    def _ask(self) -> None:
        with closing(self._connection):
            self._connection.request("POST", "/api/v1/stop")
            assert json.loads(self._connection.getresponse().read())["stands_still"] is True
            self._at = time.monotonic()

    def seconds(self, since: float) -> float:
        self._thread.join(LATE)
        return self._at - since


class RosbridgeDriver:
    """Publishes velocities through a rosbridge server."""

    def __init__(self, url: str) -> None:
        self.client = RosbridgeClient(url)
        self.client.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist")

    def publish(self, x: float) -> None:
        self.client.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": x}})

    def close(self) -> None:
        self.client.close()


class FoxgloveDriver:
    """Publishes velocities through a Foxglove server."""

    def __init__(self, url: str) -> None:
        self.client = Viewer(url)
        self.channel = self.client.advertise("/cmd_vel", "geometry_msgs/Twist")

    def publish(self, x: float) -> None:
        self.client.publish(self.channel, struct.pack("<6d", x, 0, 0, 0, 0, 0))

    def close(self) -> None:
        self.client.close()


def gateway(kind: str, floods: Sequence[str], clients: Sequence[int], trials: int) -> None:
    """Time another client's zero."""
    protocol = "foxglove.sdk.v1" if kind == "foxglove" else ""
    with ExitStack() as stack:
        gateway = stack.enter_context(GatewayProcess(kind="foxglove" if kind == "foxglove" else "rosbridge"))
        node = stack.enter_context(Node("/robot", master_uri=gateway.master_uri, intraprocess=False))
        got: list[tuple[float, float]] = []

        def take(message: Any) -> None:
            got.append((time.monotonic(), message.linear.x))

        subscriber = node.subscriber("/cmd_vel", "geometry_msgs/Twist", take, queue_size=1000)
        driver = {"bridge": RosbridgeDriver, "foxglove": FoxgloveDriver}[kind](gateway.url)
        stack.callback(driver.close)
        subscriber.wait_for_connection(20)

        def zeros(what: str, number: int) -> None:
            took = []
            for _ in range(trials):
                driver.publish(0.1)
                time.sleep(0.1)
                asked = time.monotonic()
                driver.publish(0.0)
                while not any(at > asked and x == 0 for at, x in got):
                    if time.monotonic() > asked + LATE:
                        raise TimeoutError("zero did not come")
                    time.sleep(0.002)
                took.append(next(at for at, x in got if at > asked and x == 0) - asked)
                got.clear()
                time.sleep(0.6)  # the gateway's own zeros are over
                got.clear()
            row(what, number, zero=took)

        zeros("none", 0)
        for what in floods:
            for number in clients:
                with Crowd(gateway.port, what, number, protocol=protocol):
                    zeros(what, number)
                print(f"    memory: {gateway.memory() / 1e6:.0f} MB at most", flush=True)
        time.sleep(5.0)
        print(f"memory: {gateway.memory() / 1e6:.0f} MB at most, {gateway.memory('VmRSS') / 1e6:.0f} MB stay")
        crowd = stack.enter_context(Crowd(gateway.port, floods[0], max(clients), protocol=protocol))
        assert crowd
        time.sleep(1.0)
        began = time.monotonic()
        gateway.process.send_signal(signal.SIGTERM)
        gateway.process.wait(30)
        print(f"SIGTERM: {time.monotonic() - began:.2f} s")
