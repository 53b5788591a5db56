"""`woosh mcp` as hosts start it: over stdio and HTTP, and at `/mcp` of the page's server; what it refuses."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.support.extras import needs
from woosh_pure import Chassis, SimulatedChassis

needs("mcp")
needs("web")

import httpx2  # noqa: E402 (after the skip)
from mcp import Client  # noqa: E402
from mcp.client.stdio import StdioServerParameters  # noqa: E402
from mcp_types import ElicitResult  # noqa: E402

from woosh_pure.mcp import Limits, robots  # noqa: E402
from woosh_pure.mcp.door import Door, alone, mount  # noqa: E402
from woosh_pure.web.access import AccessRules  # noqa: E402
from woosh_pure.web.server import WebServer  # noqa: E402

BOTH = pytest.mark.parametrize("mode", ["auto", "legacy"])
TOKEN = "a-long-enough-token"
DRIVE = ("go_to_mark", {"mark": "A2"})


@pytest.fixture(scope="module")
def sim() -> Iterator[SimulatedChassis]:
    with SimulatedChassis(full_graph=False) as chassis:
        yield chassis


@pytest.fixture
def watcher(sim: SimulatedChassis) -> Iterator[Chassis]:
    """Another program, which sees the robot move."""
    sim.reset()
    with Chassis(sim.master_uri, robot_api=False) as chassis:
        chassis.measured_velocity.wait()
        yield chassis


def moves(chassis: Chassis) -> bool:
    return not chassis.measured_velocity.wait(5.0, new=False).is_standing()


async def until(accept: Any, seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not accept():
        assert time.monotonic() < end
        await asyncio.sleep(0.02)


async def agrees(ctx: Any, params: Any) -> ElicitResult:
    return ElicitResult(action="accept", content={"allow": True})


def command(sim: SimulatedChassis, *options: str) -> list[str]:
    return [sys.executable, "-m", "woosh_pure", "--master", sim.master_uri, "mcp", "--allow-motion", *options]


@contextmanager
def serving(chassis: Chassis, token: str | None = None) -> Iterator[str]:
    """The HTTP server of `woosh mcp --http`; its URL."""
    made = Door(robots({"robot": chassis}), Limits(), allow_motion=True, confirm="always")
    app = alone(made, AccessRules(token, (), ["127.0.0.1"]))
    with WebServer(app, port=0) as server:
        yield f"{server.url}mcp"


@asynccontextmanager
async def over(url: str, mode: str = "auto") -> AsyncIterator[Client]:
    async with Client(url, mode=mode, elicitation_callback=agrees) as client:  # type: ignore[arg-type]
        yield client


@pytest.mark.slow
@BOTH
def test_over_stdio_a_motion_ends_with_the_host(mode: str, sim: SimulatedChassis, watcher: Chassis) -> None:
    """The client goes while the robot drives; stdout carries nothing but the protocol."""

    async def work() -> None:
        words = command(sim)
        server = StdioServerParameters(command=words[0], args=words[1:])
        async with Client(server, mode=mode, elicitation_callback=agrees) as client:  # type: ignore[arg-type]
            turned = (await client.call_tool("turn", {"angle_deg": 3})).structured_content
            assert turned is not None
            assert turned["outcome"] == "reached"
            call = asyncio.ensure_future(client.call_tool(*DRIVE))
            await until(lambda: moves(watcher))
            call.cancel()
            await asyncio.gather(call, return_exceptions=True)
        await until(lambda: not moves(watcher))

    asyncio.run(asyncio.wait_for(work(), 90.0))


@pytest.mark.slow
def test_the_end_of_stdin_and_of_the_process(sim: SimulatedChassis) -> None:
    """It ends by itself at the end of stdin, and says on stderr what it has to say."""
    done = subprocess.run(command(sim), stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, "")
    with subprocess.Popen(
        command(sim), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        threading.Timer(3.0, process.send_signal, (signal.SIGTERM,)).start()
        assert process.stdout is not None
        assert process.stdout.read() == b""
        assert process.wait(30) != 0


def test_over_http_both_eras_read_and_the_newer_moves(sim: SimulatedChassis, watcher: Chassis) -> None:
    """A client of an older protocol is refused with the reason; a closed stream ends the motion of a newer one."""

    async def work(url: str, chassis: Chassis) -> None:
        async with over(url, "legacy") as old, over(url) as new:
            assert (await old.call_tool("state", {})).structured_content
            refused = (await old.call_tool(*DRIVE)).structured_content
            assert refused is not None
            assert refused["outcome"] == "refused"
            assert "2026-07-28" in refused["sentence"]
            assert not chassis.moved
            call = asyncio.ensure_future(new.call_tool(*DRIVE))
            await until(lambda: moves(watcher))
            second = (await new.call_tool("turn", {"angle_deg": 3})).structured_content
            assert second is not None
            assert second["outcome"] == "refused"
            call.cancel()
            await asyncio.gather(call, return_exceptions=True)
            await until(lambda: not moves(watcher))
            await until(lambda: chassis.lease.holder is None)

    with Chassis(sim.master_uri, robot_api=False) as chassis, serving(chassis) as url:
        asyncio.run(asyncio.wait_for(work(url, chassis), 60.0))


def test_one_guard_for_host_origin_and_token(sim: SimulatedChassis) -> None:
    body = {"jsonrpc": "2.0", "id": 1, "method": "tools/list"}
    accept = {"accept": "application/json, text/event-stream"}
    with (
        Chassis(sim.master_uri, robot_api=False) as chassis,
        serving(chassis, TOKEN) as url,
        httpx2.Client() as http,
    ):
        right = {**accept, "authorization": f"Bearer {TOKEN}"}
        assert http.post(url, json=body, headers=accept).status_code == 401
        assert (
            http.post(url, json=body, headers={**accept, "authorization": "Bearer wrong token"}).status_code
            == 401
        )
        assert http.post(url, json=body, headers={**right, "host": "evil.example"}).status_code == 421
        assert (
            http.post(url, json=body, headers={**right, "origin": "https://evil.example"}).status_code == 403
        )
        assert http.post(url, json=body, headers=right).status_code not in (401, 403, 421)
        assert http.post(url, content=b"x" * 100_000, headers=right).status_code == 413
        assert http.get(url.removesuffix("mcp"), headers=right).status_code == 404, "nothing else is served"


def test_at_the_page_a_person_takes_the_robot_over(sim: SimulatedChassis, tmp_path: Path) -> None:
    """`/mcp` shares journal, lease and guard with the page: its REST API asks twice, and the motion ends."""
    from woosh_pure import web

    async def work(url: str, chassis: Chassis) -> None:
        async with over(f"{url}mcp") as client, httpx2.AsyncClient(base_url=f"{url}api/v1/") as page:
            call = asyncio.ensure_future(client.call_tool(*DRIVE))
            await until(lambda: chassis.under_way)
            asked = (await page.post("lease", json={})).json()
            assert (asked["holder"], asked["yours"]) == ("assistant", False)
            taken = (await page.post("lease", json={"take_over": True})).json()
            assert taken["yours"]
            moved = (await call).structured_content
            assert moved is not None
            assert moved["outcome"] == "stopped"
            assert "taken the robot over" in moved["sentence"]
            journal = (await page.get("journal")).json()
            calls = [(one["what"], one["state"]) for one in journal if one["who"] == "assistant"]
            assert calls == [("go_to_mark(mark=A2)", "stopped")]

    with Chassis(sim.master_uri, robot_api=False, missions_state=tmp_path) as chassis:
        mount(app := web.app(chassis), Limits(), allow_motion=True, confirm="always")
        with WebServer(app, port=0) as server:
            asyncio.run(asyncio.wait_for(work(server.url, chassis), 60.0))
