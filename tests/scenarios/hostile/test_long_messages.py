"""Clients of a gateway that send all they can: those who drive are served, and zero is in time."""

from __future__ import annotations

import json
import socket
import struct
import sys
import threading
import time
from typing import Any

import pytest

from rosproto import Node
from tests.support.gateway_flood import PAYLOADS, Crowd, GatewayProcess, frame
from tests.support.load import crowd
from tests.support.rosbridge_client import RosbridgeClient

pytest.importorskip("websockets", reason="websockets is not installed")

IN_TIME = 0.5  # seconds, for a zero, on a quiet computer
SILENCE = 0.5  # after which the gateway sends one by itself
MAX_MEMORY = 300 << 20


class Robot:
    """Notes when the velocities on /cmd_vel arrive."""

    def __init__(self, node: Node) -> None:
        self._changed = threading.Condition()
        self.got: list[tuple[float, float]] = []
        self.subscriber = node.subscriber("/cmd_vel", "geometry_msgs/Twist", self._take, queue_size=1000)

    def _take(self, message: Any) -> None:
        with self._changed:
            self.got.append((time.monotonic(), message.linear.x))
            self._changed.notify_all()

    def when(self, speed: float, since: float, seconds: float = 30.0) -> float:
        """Seconds from `since` to the first velocity of this speed that came after it."""

        def found() -> float | None:
            return next((at - since for at, x in self.got if x == speed and at >= since), None)

        with self._changed:
            assert self._changed.wait_for(lambda: found() is not None, seconds), f"{speed} did not come"
            took = found()
        assert took is not None
        return took


@pytest.mark.promise("zero within half a second, at most 300 MB")
@pytest.mark.slow
@pytest.mark.parametrize("clients", [1, 64])
@pytest.mark.parametrize("what", list(PAYLOADS))
def test_zero_is_in_time_while_clients_send_all_they_can(what: str, clients: int) -> None:
    """The driver's own zero, the gateway's after its silence and the one after its end; within 300 MB."""
    in_time = IN_TIME * crowd()
    with (
        GatewayProcess() as gateway,
        Node("/robot", master_uri=gateway.master_uri, intraprocess=False) as node,
    ):
        robot = Robot(node)
        with Crowd(gateway.port, what, clients), RosbridgeClient(gateway.url) as driver:
            driver.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist")
            robot.subscriber.wait_for_connection(20)
            took: dict[str, list[float]] = {"own": [], "silent": []}
            for turn in (1, 2):
                speed = 0.01 * turn
                for _ in range(5):
                    driver.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": speed}})
                    time.sleep(0.05)
                asked = time.monotonic()
                driver.send(op="publish", topic="/cmd_vel", msg={})
                took["own"].append(robot.when(0.0, asked))
                last = time.monotonic()
                driver.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": speed + 0.5}})
                robot.when(speed + 0.5, last)
                took["silent"].append(robot.when(0.0, last) - SILENCE)
            driver.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.9}})
            robot.when(0.9, 0.0)
            left = time.monotonic()
            driver.abort()
            took["left"] = [robot.when(0.0, left)]
        worst = {how: round(max(times), 3) for how, times in took.items()}
        print(f"{what}, {clients} clients: {worst} s, {gateway.memory() / 1e6:.0f} MB", file=sys.stderr)
        assert max(worst.values()) < in_time, worst
        assert gateway.memory() < MAX_MEMORY


@pytest.mark.promise("Requests that a client sent before its connection was reset are dropped")
@pytest.mark.slow
def test_a_client_that_is_torn_off_leaves_no_velocities_to_play_out() -> None:
    """Twenty thousand at once, and a reset: zero comes within half a second, and nothing after it."""
    in_time = IN_TIME * crowd()
    with (
        GatewayProcess() as gateway,
        Node("/robot", master_uri=gateway.master_uri, intraprocess=False) as node,
    ):
        robot = Robot(node)
        client = RosbridgeClient(gateway.url)
        client.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist")
        robot.subscriber.wait_for_connection(20)
        drive = {"op": "publish", "topic": "/cmd_vel", "msg": {"linear": {"x": 0.5}}}
        sock = client.socket
        sock.sendall(frame(json.dumps(drive).encode()) * 20_000)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        left = time.monotonic()
        client.abort()
        took = robot.when(0.0, left)
        time.sleep(1.0)
        after = [x for at, x in robot.got if at > left + took and x]
        print(f"zero after {took:.3f} s, {len(robot.got)} of 20000 came", file=sys.stderr)
        assert took < in_time
        assert after == []
