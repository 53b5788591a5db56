"""What clients that send all they can cost the others: STOP of the page, zero of a gateway, memory, and the end.

    python -m tests.benchmarks floods [--trials 10] [--clients 1,63] [--only page,bridge] [--what NAME,NAME]

* page: the robot turns, and POST stop is sent beside clients that flood live connections: seconds until it stands still,
  by its odometry, and until the answer.
* bridge: seconds until another client's zero velocity arrives, beside clients that flood a rosbridge server; memory of the
  server at its peak and five seconds after all floods; seconds from SIGTERM to its end.

Each row has the median and the longest of all trials. `--what` names rows of `tests.support.gateway_flood.PAYLOADS`.
"""

from __future__ import annotations

import argparse
import http.client
import json
import signal
import statistics
import time
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

from rosproto import Node
from tests.support.gateway_flood import Crowd, GatewayProcess, PageProcess
from tests.support.rosbridge_client import RosbridgeClient
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
    parser.add_argument("--only", default="page,bridge")
    parser.add_argument("--what", default=None)
    args = parser.parse_args(arguments)
    clients = [int(number) for number in args.clients.split(",")]
    for part in args.only.split(","):
        what = args.what.split(",") if args.what else [*FRAMES, *(["raw types"] if part == "bridge" else [])]
        {"page": page, "bridge": bridge}[part](what, clients, args.trials)


def row(name: str, clients: int, **took: Sequence[float]) -> None:
    figures = ", ".join(
        f"{what} {statistics.median(t):.2f} (longest {max(t):.2f}) s" for what, t in took.items()
    )
    print(f"{name}, {clients} clients, {len(next(iter(took.values())))} trials: {figures}", flush=True)


def page(floods: Sequence[str], clients: Sequence[int], trials: int) -> None:
    """Time STOP."""
    with (
        SimulatedChassis(full_graph=False) as sim,
        Chassis(sim.master_uri) as chassis,
        PageProcess(sim.master_uri) as server,
    ):
        chassis.odometry.wait(timeout=20)
        stops(chassis, server, trials, "none", 0)
        for what in floods:
            for number in clients:
                with Crowd(server.port, what, number, LIVE):
                    stops(chassis, server, trials, what, number)
        print(f"memory: {server.memory() / 1e6:.0f} MB at most", flush=True)


def stops(chassis: Chassis, server: PageProcess, trials: int, what: str, clients: int) -> None:
    stood, answered = [], []
    for _ in range(trials):
        goal = chassis.rotate(60.0, several_turns=True)
        until_turning(chassis, True)
        began = time.monotonic()
        answer = Answer(server.port)
        until_turning(chassis, False)
        stood.append(time.monotonic() - began)
        answered.append(answer.seconds(began))
        goal.cancel()
    row(what, clients, standstill=stood, answer=answered)


def until_turning(chassis: Chassis, turning: bool) -> None:
    end = time.monotonic() + LATE
    while (abs(chassis.odometry.wait(timeout=LATE).velocity.wz) > 0.01) is not turning:
        if time.monotonic() > end:
            raise TimeoutError(f"the robot {'does not turn' if turning else 'goes on'}")
        time.sleep(0.01)


class Answer:
    """The answer to POST stop, in a thread."""

    def __init__(self, port: int) -> None:
        import threading

        self._port, self._at = port, LATE
        self._thread = threading.Thread(target=self._ask, daemon=True)
        self._thread.start()

    def _ask(self) -> None:
        connection = http.client.HTTPConnection("127.0.0.1", self._port, timeout=LATE)
        try:
            connection.request("POST", "/api/v1/stop")
            assert json.loads(connection.getresponse().read())["stands_still"] is True
            self._at = time.monotonic()
        finally:
            connection.close()

    def seconds(self, since: float) -> float:
        self._thread.join(LATE)
        return self._at - since


def bridge(floods: Sequence[str], clients: Sequence[int], trials: int) -> None:
    """Time another client's zero."""
    with ExitStack() as stack:
        gateway = stack.enter_context(GatewayProcess())
        node = stack.enter_context(Node("/robot", master_uri=gateway.master_uri, intraprocess=False))
        got: list[tuple[float, float]] = []

        def take(message: Any) -> None:
            got.append((time.monotonic(), message.linear.x))

        subscriber = node.subscriber("/cmd_vel", "geometry_msgs/Twist", take, queue_size=1000)
        driver = stack.enter_context(RosbridgeClient(gateway.url))
        driver.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist")
        subscriber.wait_for_connection(20)

        def zeros(what: str, number: int) -> None:
            took = []
            for _ in range(trials):
                driver.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.1}})
                time.sleep(0.1)
                asked = time.monotonic()
                driver.send(op="publish", topic="/cmd_vel", msg={})
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
                with Crowd(gateway.port, what, number):
                    zeros(what, number)
                print(f"    memory: {gateway.memory() / 1e6:.0f} MB at most", flush=True)
        time.sleep(5.0)
        print(f"memory: {gateway.memory() / 1e6:.0f} MB at most, {gateway.memory('VmRSS') / 1e6:.0f} MB stay")
        crowd = stack.enter_context(Crowd(gateway.port, floods[0], max(clients)))
        assert crowd
        time.sleep(1.0)
        began = time.monotonic()
        gateway.process.send_signal(signal.SIGTERM)
        gateway.process.wait(30)
        print(f"SIGTERM: {time.monotonic() - began:.2f} s")
