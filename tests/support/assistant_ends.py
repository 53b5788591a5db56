"""End an assistant, or what is between it and the robot, while the robot drives; measure when the robot stands.

`python -m tests.support.assistant_ends stdio kill 50` prints each trial, the median and the longest. The first word is
the way (stdio, http), the second what happens:

* kill: the host program is killed (SIGKILL)
* leave: it closes the connection in the middle of the call
* cancel: it cancels the call and stays
* stop: it is stopped (SIGSTOP), so that nothing is closed
* server: `woosh mcp` itself is killed; its watchdog is left
* cut: the cable between two computers is cut (http; network namespaces, so root)

The simulated chassis runs in a process of its own, which looks at the pose all the time: the robot stands from the moment
after which it stays where it is.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import random
import signal
import statistics
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AsyncExitStack, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.support.air import Air
from tests.support.hosts import ROBOT, Host, two_hosts
from tests.support.remote import Remote
from tests.support.ros_process import RosProcess

__all__ = ["KINDS", "LIMIT", "PROMISED", "SILENT", "Trial", "World", "open_world"]

ROOT = Path(__file__).resolve().parents[2]
KINDS = {
    "stdio": ("kill", "leave", "cancel", "stop", "server"),
    "http": ("kill", "leave", "cancel", "stop", "server", "cut"),
}
SILENT = ("stop", "cut")
"""After these nothing is closed: only the time limit of the motion ends it."""
PROMISED = 1.0  # s, from the end of the connection
LIMIT = 8.0  # s, `--max-seconds` where nothing is closed
TOKEN = "only-for-this-test"
LONGEST_DELAY = 1.0  # s of driving before it happens, at most
SIMULATOR = """
import threading
from woosh_pure import SimulatedChassis
from woosh_pure.sim import Settings

sim = SimulatedChassis(host=HOST, full_graph=False, settings=Settings(navigation_speed=0.2)).__enter__()
start = last = sim.pose
moved = time.monotonic()

def look():
    global last, moved
    while True:
        pose = sim.pose
        if pose.distance_to(last) > 0.0005:
            last, moved = pose, time.monotonic()
        time.sleep(0.005)

def begin():
    global start
    sim.teleport(0.0, 0.0, 0.0)
    start = sim.pose

def under_way():
    return sim.pose.distance_to(start) > 0.03

def stood_from():
    # The moment at which it moved last, once it has stood for a second; until then None.
    return moved if time.monotonic() - moved > 1.0 else None

threading.Thread(target=look, daemon=True).start()
"""

_NETWORKS = threading.Lock()


# -- the host: a program with the SDK's own client ----------------------------------------------------------


async def host(where: list[str] | str, mode: Any, token: str) -> None:
    """Drive to a mark; on SIGUSR1 leave in the middle of the call, on SIGUSR2 cancel it and stay.

    Args:
        where: The words of the server's command, or its URL.
        mode: Of the SDK's client: auto or legacy.
        token: For a URL; "" for none.
    """
    import httpx2
    from mcp import Client, StdioServerParameters
    from mcp.client.streamable_http import streamable_http_client

    async with AsyncExitStack() as stack:
        server: Any
        if isinstance(where, str):
            headers = {"Authorization": f"Bearer {token}"} if token else {}
            http = await stack.enter_async_context(httpx2.AsyncClient(headers=headers, timeout=300.0))
            server = streamable_http_client(where, http_client=http)
        else:
            server = StdioServerParameters(
                command=where[0], args=where[1:], env=dict(os.environ), cwd=str(ROOT)
            )
        client = await stack.enter_async_context(Client(server, mode=mode))
        told = asyncio.Event()
        call = asyncio.create_task(
            client.call_tool("go_to_mark", {"mark": "A1"}, progress_callback=_progress)
        )
        loop = asyncio.get_running_loop()
        loop.add_signal_handler(signal.SIGUSR1, told.set)
        loop.add_signal_handler(signal.SIGUSR2, call.cancel)
        print("called", flush=True)
        leaving = asyncio.create_task(told.wait())
        await asyncio.wait([call, leaving], return_when=asyncio.FIRST_COMPLETED)
        if call.cancelled():
            print("cancelled", flush=True)
        elif call.done():
            print("ended", call.exception() or call.result(), flush=True)
        await told.wait()  # it stays, as an assistant does


async def _progress(progress: float, total: float | None, message: str | None) -> None:
    print("progress", progress, message, flush=True)


# -- the trials ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Trial:
    """One drive that ended early.

    Attributes:
        after: Seconds from what happened until the robot stood.
        whole: Seconds from its first 3 cm until the robot stood.
        metres: The length of the drive; the mark is 3.2 m away.
    """

    after: float
    whole: float
    metres: float

    def __str__(self) -> str:
        return f"stood {self.after:.3f} s after it, {self.whole:.3f} s after it began to move, {self.metres:.2f} m"


class World:
    """The simulated chassis and, for http, one server that stays; `open_world` makes it.

    Args:
        way: stdio or http.
        mode: Of the SDK's client: auto or legacy.
        stack: What is started ends with it.
        network: Whether robot and host are two computers with a cable between them.
        max_seconds: The server's limit for a motion.
    """

    def __init__(self, way: str, mode: str, stack: ExitStack, *, network: bool, max_seconds: float) -> None:
        self.way, self.mode, self.max_seconds = way, mode, max_seconds
        self._stack = stack
        self._robot: Host | None = None
        self._laptop: Host | None = None
        self.air: Air | None = None
        self._env = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}
        if network:
            with _NETWORKS:  # the devices of a process have one name until they are in their places
                self._robot, self._laptop, self.air = stack.enter_context(two_hosts())
            self.sim: Remote = self._robot.python
        else:
            self.sim = stack.enter_context(Remote())
        self.sim.do(SIMULATOR.replace("HOST", repr(ROBOT if network else "127.0.0.1")))
        self.server: RosProcess | None = None
        self.url = ""

    def command(self) -> list[str]:
        master = self.sim.ask("sim.master_uri")
        limits = ["--allow-motion", "--confirm", "never", "--max-seconds", str(self.max_seconds)]
        return [sys.executable, "-m", "woosh_pure", "--master", master, "mcp", *limits]

    def serve(self) -> None:
        """Start the server of http, unless it runs."""
        if self.server is not None and self.server.running:
            return
        words = [*self.command(), "--http", "0", "--token", TOKEN]
        if self._robot is not None:
            words = [*self._robot.prefix, *words, "--bind", ROBOT]
        self.server = self._stack.enter_context(RosProcess(words, self._env))
        self.url = self.server.wait_for(r"http://[\w.:]+/mcp")[0]

    def trial(self, kind: str, delay: float) -> Trial:
        """One drive; after some seconds of it, something happens."""
        self.sim.do("begin()")
        if self.way == "http":
            self.serve()
            where: object = self.url
        else:
            # The shell gives its process id away, and becomes the server.
            where = ["sh", "-c", 'echo "server $$" >&2; exec "$@"', "sh", *self.command()]
        words = [sys.executable, "-m", "tests.support.assistant_ends", "host"]
        words += [json.dumps(where), self.mode, TOKEN if self.way == "http" else ""]
        with ExitStack() as stack:
            prefix = self._laptop.prefix if self._laptop is not None else []
            process = RosProcess([*prefix, *words], self._env)
            stack.callback(process.stop, 0.0)
            process.wait_for(r"^called$")
            try:
                moving = self.sim.eventually("under_way()", 30.0)
            except AssertionError as error:
                raise AssertionError(f"{error}\n{process.output}") from None
            time.sleep(delay)  # the random moment
            happened = time.monotonic()
            self._let_happen(kind, process)
            stood = self._standing(process)
            if self.air is not None:
                self.air.there.open = self.air.back.open = True
            if kind == "stop":
                os.kill(process.pid, signal.SIGCONT)
        return Trial(stood - happened, stood - moving, float(self.sim.ask("sim.pose.distance_to(start)")))

    def _let_happen(self, kind: str, process: RosProcess) -> None:
        if kind == "cut":
            assert self.air is not None
            self.air.there.open = self.air.back.open = False
        elif kind == "server" and self.way == "stdio":
            os.kill(int(process.wait_for(r"^server (\d+)$")[1]), signal.SIGKILL)
        elif kind == "server":
            assert self.server is not None
            os.kill(self.server.pid, signal.SIGKILL)
            self.server.wait()
        else:
            signals = {"kill": signal.SIGKILL, "leave": signal.SIGUSR1, "cancel": signal.SIGUSR2}
            os.kill(process.pid, signals.get(kind, signal.SIGSTOP))

    def _standing(self, process: RosProcess) -> float:
        try:
            self.sim.eventually("stood_from()", 40.0)
        except AssertionError as error:
            raise AssertionError(f"{error}\n{process.output}") from None
        return float(self.sim.ask("stood_from()"))


@contextmanager
def open_world(way: str, kind: str, mode: str = "auto", max_seconds: float = 60.0) -> Iterator[World]:
    """A robot for trials of this kind.

    Args:
        way: stdio or http.
        kind: One of `KINDS`.
        mode: Of the SDK's client: auto or legacy.
        max_seconds: `--max-seconds`.
    """
    with ExitStack() as stack:
        yield World(way, mode, stack, network=kind == "cut", max_seconds=max_seconds)


def main() -> None:
    if sys.argv[1:2] == ["host"]:
        asyncio.run(host(json.loads(sys.argv[2]), *sys.argv[3:5]))
        return
    parser = argparse.ArgumentParser(allow_abbrev=False)
    parser.add_argument("way", choices=sorted(KINDS))
    parser.add_argument("kind", choices=KINDS["http"])
    parser.add_argument("trials", type=int)
    parser.add_argument("--mode", choices=("auto", "legacy"), default="auto", help="of the SDK's client")
    parser.add_argument("--max-seconds", type=float)
    parser.add_argument("--beside", type=int, default=1, help="so many robots at a time (1)")
    parser.add_argument("--seed", type=int, default=time.time_ns() % 10_000)
    arguments = parser.parse_args()
    if arguments.kind not in KINDS[arguments.way]:
        parser.error(f"{arguments.way} has no {arguments.kind}")
    print("seed", arguments.seed)
    shares = [range(first, arguments.trials, arguments.beside) for first in range(arguments.beside)]
    limit = arguments.max_seconds or (LIMIT if arguments.kind in SILENT else 60.0)

    def share(numbers: range) -> list[Trial]:
        made = []
        with open_world(arguments.way, arguments.kind, arguments.mode, limit) as world:
            for number in numbers:
                chance = random.Random(f"{arguments.seed}-{number}")
                trial = world.trial(arguments.kind, chance.uniform(0.0, LONGEST_DELAY))
                made.append(trial)
                print(f"{number + 1}: {trial}", flush=True)
        return made

    with ThreadPoolExecutor(arguments.beside) as pool:
        done = [trial for made in pool.map(share, shares) for trial in made]
    for name, of in (("after it", lambda t: t.after), ("after it began to move", lambda t: t.whole)):
        seconds = [of(trial) for trial in done]
        print(f"{name}: median {statistics.median(seconds):.3f} s, longest {max(seconds):.3f} s")
    late = [
        t for t in done if (t.whole > limit + PROMISED if arguments.kind in SILENT else t.after > PROMISED)
    ]
    print(f"{len(done)} trials, {len(late)} later than promised")


if __name__ == "__main__":
    main()
