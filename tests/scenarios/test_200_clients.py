"""`--max-clients 200` of the three servers: each client gets messages, one more is refused, and a stop is obeyed.

The server is a process of its own, as is the graph. How fast it is: `python -m tests.benchmarks web --only stops`.
"""

from __future__ import annotations

import asyncio
import http.client
import json
import os
import subprocess
import sys
from collections.abc import Awaitable, Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

import websockets

from rosproto import Node
from woosh_pure import SimulatedChassis

pytestmark = pytest.mark.slow  # 200 clients

CLIENTS, STOPS = 200, 10
ROOT = Path(__file__).resolve().parents[2]
ZERO = {"linear": {"x": 0.0, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}


@contextmanager
def served(*words: str) -> Iterator[subprocess.Popen[str]]:
    """A server as a process; its output is on `stdout`."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1", "LC_ALL": "C.UTF-8"}
    command = [sys.executable, "-m", *words, "--port", "0", "--max-clients", str(CLIENTS)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, env=environment) as process:
        try:
            yield process
        finally:
            process.terminate()
            process.wait(20)


async def crowd(
    url: str, greet: Callable[[Any], Awaitable[Any]], answer: str = "", **options: Any
) -> tuple[list[Any], list[int], list[asyncio.Task[None]]]:
    """So many clients, each greeted; how many messages each has got; and what reads them."""
    counts = [0] * CLIENTS
    connections = []
    for _ in range(CLIENTS):
        one = await websockets.connect(url, open_timeout=30, max_size=None, compression=None, **options)
        await greet(one)
        connections.append(one)

    async def read(number: int) -> None:
        async for _ in connections[number]:
            counts[number] += 1
            if answer:
                await connections[number].send(answer % counts[number])

    return connections, counts, [asyncio.ensure_future(read(number)) for number in range(CLIENTS)]


async def everybody_gets_messages(counts: list[int]) -> None:
    """Wait until each client has got some more."""
    before = list(counts)
    for _ in range(600):
        waiting = sum(now < then + 3 for now, then in zip(counts, before, strict=True))
        if not waiting:
            return
        await asyncio.sleep(0.1)
    raise AssertionError(f"{waiting} of {len(counts)} got nothing")


async def close(connections: list[Any], reading: list[asyncio.Task[None]]) -> None:
    for task in reading:
        task.cancel()
    await asyncio.gather(*(one.close() for one in connections), return_exceptions=True)


async def nobody(_: object) -> None:
    """Greets nobody."""


@pytest.mark.parametrize("kind", ["bridge", "foxglove"])
def test_a_gateway_serves_200_clients(kind: str, sim: SimulatedChassis) -> None:
    """All read odometry; another one sends zeros, and they arrive at the robot's topic."""

    async def talk(url: str, arrived: Callable[[], object]) -> None:
        options: dict[str, Any] = {}
        channel = 0
        if kind == "foxglove":
            options["subprotocols"] = ["foxglove.websocket.v1"]
            async with websockets.connect(url, max_size=None, **options) as first:
                while not channel:
                    document = json.loads(await asyncio.wait_for(first.recv(), 30))
                    for one in document.get("channels", ()):
                        channel = one["id"] if one["topic"] == "/odom" else channel

        async def greet(one: Any) -> None:
            if kind == "bridge":
                await one.send(json.dumps({"op": "subscribe", "topic": "/odom", "type": "nav_msgs/Odometry"}))
            else:
                await one.send(
                    json.dumps({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": channel}]})
                )

        connections, counts, reading = await crowd(url, greet, **options)
        with pytest.raises(websockets.InvalidStatus, match="503"):
            await websockets.connect(url, **options)
        driver = connections[0]
        if kind == "bridge":
            await driver.send(
                json.dumps({"op": "advertise", "topic": "/stops", "type": "geometry_msgs/Twist"})
            )
            zero: Any = json.dumps({"op": "publish", "topic": "/stops", "msg": ZERO})
        else:
            channels = [{"id": 7, "topic": "/stops", "encoding": "json", "schemaName": "geometry_msgs/Twist"}]
            await driver.send(json.dumps({"op": "advertise", "channels": channels}))
            zero = b"\x01" + (7).to_bytes(4, "little") + json.dumps(ZERO).encode()
        await everybody_gets_messages(counts)
        for _ in range(STOPS):
            await driver.send(zero)
            await asyncio.to_thread(arrived)
        await everybody_gets_messages(counts)
        await close(connections, reading)

    with (
        Node("/robot_of_200", master_uri=sim.master_uri) as robot,
        served("rosproto", kind, "--master", sim.master_uri, "--allow-write", "topic:/stops") as process,
    ):
        stops = robot.subscriber("/stops", "geometry_msgs/Twist", queue_size=100)
        assert process.stdout is not None
        url = next(word for word in process.stdout.readline().split() if word.startswith("ws://"))
        asyncio.run(talk(url, lambda: stops.next(20)))


def test_the_page_s_server_serves_200_viewers(sim: SimulatedChassis, private_config: Path) -> None:
    """All are shown the robot, and acknowledge each frame as a page does; somebody presses STOP."""

    async def talk(port: int) -> None:
        url = f"ws://127.0.0.1:{port}/api/v1/live"

        def stop() -> None:
            with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=60)) as connection:
                connection.request("POST", "/api/v1/stop")
                response = connection.getresponse()
                assert response.status == 200
                assert json.load(response)["stands_still"] is True

        connections, counts, reading = await crowd(url, nobody, '{"t":"ack","n":%d}')
        one_more = await websockets.connect(url)
        await asyncio.wait_for(one_more.wait_closed(), 10)
        assert one_more.close_code == 4429
        await everybody_gets_messages(counts)
        for _ in range(STOPS):
            await asyncio.to_thread(stop)
        await everybody_gets_messages(counts)
        await close(connections, reading)

    with served("woosh_pure", "web", "--master", sim.master_uri, "--no-browser", "--json") as process:
        assert process.stdout is not None
        asyncio.run(talk(json.loads(process.stdout.readline())["port"]))
