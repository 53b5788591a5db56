"""What `woosh web` costs, and how late the page is, in a headless Chromium.

    python -m tests.benchmarks web [--seconds 15] [--rounds 3] [--viewers 1,10] [--only paint,pose,viewers,stops]

* paint: from the address to the first paint, to marks that can be touched, and to the map with the robot in it; in a
  browser that has never seen the page, and again in the same one.
* pose: from the simulator's publishing to each station on the way: a `Chassis` in Python, a program at the
  WebSocket, the page's script, the screen (after the frame that shows it). All four in the same run, on the same clock.
* viewers: processor of the server's process without a viewer, with one and with many, and what each of them gets,
  with and without the camera's picture.
* stops: how long POST stop takes, in which the robot is seen to stand, beside so many viewers (`--viewers 200`).

Simulator, server and browser are processes of their own. The viewers of the last row are this process: ten pages
of a browser would take the processor that is measured.
"""

from __future__ import annotations

import argparse
import asyncio
import bisect
import json
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from tests.benchmarks._figures import Table, spread
from tests.benchmarks.gateway import Server, percentile

ROWS = ("paint", "pose", "viewers", "stops")
TARGET = 0.2  # s, 95th percentile, from the simulator to the screen on a quiet machine
_POSE = "/movebase_pose2d"
Key = tuple[float, float, float]


def run(arguments: list[str]) -> None:
    if arguments[:1] == ["simulate"]:
        simulate()
        return
    parser = argparse.ArgumentParser(prog="tests.benchmarks web")
    parser.add_argument("--seconds", type=float, default=15.0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--viewers", default="1,10")
    parser.add_argument("--only", default=",".join(ROWS))
    args = parser.parse_args(arguments)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        sim = stack.enter_context(Simulator())
        server = stack.enter_context(served(sim.uri, folder))
        for row in args.only.split(","):
            print(f"\n{row}", flush=True)
            globals()[f"row_{row}"](args, server, sim)


# -- processes ---------------------------------------------------------------------------------------------------


def simulate() -> None:
    """The simulator's process: its master's address, then each pose as it is published."""
    from woosh_pure import SimulatedChassis

    told = threading.Event()

    class Telling(SimulatedChassis):
        def _send(self, topic: str, filler: Any, *, always: bool = False) -> None:
            pose = self.world.believed_pose  # under the lock: what is filled in
            began = time.time()
            super()._send(topic, filler, always=always)
            if topic == _POSE and told.is_set():
                print(json.dumps([began, *_key(pose.x, pose.y, pose.yaw)]), flush=True)

    with Telling() as sim:
        print(sim.master_uri, flush=True)
        told.set()
        threading.Event().wait()


class Simulator:
    """The simulated chassis, and when it published which pose."""

    def __init__(self) -> None:
        words = [sys.executable, "-m", "tests.benchmarks", "web", "simulate"]
        self._process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout is not None
        self.uri = self._process.stdout.readline().strip()
        self._published: dict[Key, list[float]] = {}
        self._reader = threading.Thread(target=self._read, daemon=True)

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            began, *key = json.loads(line)
            self._published.setdefault((key[0], key[1], key[2]), []).append(began)

    def __enter__(self) -> Simulator:
        self._reader.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait(20)
        self._reader.join(10)

    def late(self, seen: Sequence[tuple[Key, float]], since: float) -> list[float]:
        """Milliseconds from the publishing of each pose to when it was seen, of those published since then."""
        found = []
        for key, at in seen:
            times = self._published.get(key, [])
            place = bisect.bisect_right(times, at) - 1
            if place >= 0 and times[place] >= since:
                found.append(1000 * (at - times[place]))
        return found


def _key(x: float, y: float, theta: float) -> Key:
    return round(x, 3), round(y, 3), round(theta, 3)


@contextmanager
def served(master_uri: str, folder: Path) -> Iterator[Server]:
    """`woosh web`, as a user starts it."""
    from woosh_pure.sim.site import built_in_site

    marks = {
        name: {"x": mark.pose.x, "y": mark.pose.y, "yaw": mark.pose.yaw}
        for name, mark in built_in_site().marks.items()
    }
    (folder / "marks.json").write_text(json.dumps(marks), encoding="utf-8")
    words = [
        *(sys.executable, "-m", "woosh_pure", "--master", master_uri, "--json", "web", "--port", "0"),
        *(
            "--max-clients",
            "200",
            "--no-browser",
            "--marks",
            str(folder / "marks.json"),
            "--recordings",
            str(folder),
        ),
    ]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            line = next(line for line in process.stdout if '"url"' in line)
            yield Server("woosh web", json.loads(line)["url"], process.pid)
        finally:
            process.terminate()
            process.wait(20)


@contextmanager
def moving(master_uri: str) -> Iterator[None]:
    """Slowly in a circle, so that no two poses are the same."""
    from woosh_pure import Chassis

    with Chassis(master_uri) as chassis:
        ending = threading.Event()

        def circle() -> None:
            with chassis.velocity(bypasses_protection=True) as drive:
                while not ending.wait(0.2):
                    drive.set(0.2, 0.5, valid_for=1.0)

        thread = threading.Thread(target=circle)
        thread.start()
        try:
            yield
        finally:
            ending.set()
            thread.join(10)


class Figures:
    """Of all rounds, then a table."""

    def __init__(self, columns: Sequence[str]) -> None:
        self._columns = columns
        self._found: dict[tuple[str, str], list[float]] = {}

    def note(self, row: str, column: str, value: float) -> None:
        self._found.setdefault((row, column), []).append(value)

    def print(self) -> None:
        table = Table(*self._columns)
        for (row, column), values in self._found.items():
            table.add(row, column, values)
        table.print()


# -- rows --------------------------------------------------------------------------------------------------------

_SEEN = """
window.benchmark = {poses: []};
const now = () => (performance.timeOrigin + performance.now()) / 1000;
// Told after the frame in which the page has drawn it.
const drawn = (told) => requestAnimationFrame(() => {
  const channel = new MessageChannel();
  channel.port1.onmessage = () => told(now());
  channel.port2.postMessage(0);
});
window.WebSocket = class extends WebSocket {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({data}) => {
      if (typeof data !== "string" || !data.startsWith('{"t":"pose"')) return;
      const {x, y, theta} = JSON.parse(data);
      const entry = [x, y, theta, now(), null];
      benchmark.poses.push(entry);
      drawn((at) => (entry[4] = at));
    });
  }
};
const looks = () => {
  const canvas = document.querySelector("#canvas");
  if (!benchmark.ready && document.querySelector(".markrow")) benchmark.ready = performance.now();
  if (canvas?.width > 10 && !benchmark.map) {
    const {width, height} = canvas;
    const part = canvas.getContext("2d").getImageData(width / 2 - 40, height / 2 - 40, 80, 80).data;
    if (part.every((value, at) => at % 4 !== 3 || value > 0)) benchmark.map = performance.now();
  }
  if (!benchmark.map) requestAnimationFrame(looks);
};
requestAnimationFrame(looks);
"""


def shown(page: Any) -> None:
    """Wait for it; the page's policy lets nobody evaluate text in it, Playwright's own waiting included."""
    until = time.monotonic() + 60
    while not page.evaluate("Boolean(benchmark.map && benchmark.ready)"):
        assert time.monotonic() < until, "the map was not shown within a minute"
        page.wait_for_timeout(50)


def row_paint(args: Any, server: Server, sim: Simulator) -> None:
    from tests.support.browser import opened

    columns = ("first paint, ms", "marks can be touched, ms", "the map is shown, ms", "fetched, kB")
    found = Figures(columns)
    with opened() as browser:
        for turn in range(args.rounds + 1):
            context = browser.new_context(viewport={"width": 1280, "height": 800})
            context.add_init_script(_SEEN)
            page = context.new_page()
            for name in ("never seen", "again"):
                page.goto(server.url)
                shown(page)
                figures = page.evaluate(
                    """[performance.getEntriesByType("paint").find((one) => one.name === "first-contentful-paint")
                    ?.startTime, benchmark.ready, benchmark.map,
                    performance.getEntriesByType("resource").reduce((sum, one) => sum + one.transferSize, 0) / 1e3]"""
                )
                if turn:  # the first one starts the browser, too
                    for column, value in zip(columns, figures, strict=True):
                        found.note(name, column, value)
            context.close()
    found.print()


def row_pose(args: Any, server: Server, sim: Simulator) -> None:
    from tests.support.browser import opened
    from woosh_pure import Chassis

    stations = ("a Chassis in Python", "a program at the WebSocket", "the page's script", "the screen")
    found: dict[str, list[float]] = {station: [] for station in stations}
    screens = []
    with ExitStack() as stack:
        stack.enter_context(moving(sim.uri))
        browser = stack.enter_context(opened())
        context = browser.new_context(viewport={"width": 1280, "height": 800})
        context.add_init_script(_SEEN)
        page = context.new_page()
        page.goto(server.url)
        shown(page)
        chassis = stack.enter_context(Chassis(sim.uri))
        program = stack.enter_context(Program(server.url))
        for _ in range(args.rounds):
            heard: list[tuple[Key, float]] = []
            off = chassis.pose.on(partial(_note, heard))
            since = time.time()
            page.evaluate("benchmark.poses.length = 0")
            page.wait_for_timeout(1000 * args.seconds)
            rows = [row for row in page.evaluate("benchmark.poses") if row[4] is not None]
            off()
            seen = {
                stations[0]: heard,
                stations[1]: list(program.heard),
                stations[2]: [(_key(*row[:3]), row[3]) for row in rows],
                stations[3]: [(_key(*row[:3]), row[4]) for row in rows],
            }
            for station, these in seen.items():
                late = sim.late(these, since)
                middle, most = percentile(late, 0.5), percentile(late, 0.95)
                print(
                    f"  {station:28} {len(late):5} poses, p50 {middle:6.1f}, p95 {most:6.1f} ms", flush=True
                )
                found[station] += late
            screens.append(percentile(sim.late(seen[stations[3]], since), 0.95))
        context.close()
    print("\n| from the simulator to | median, ms | 95th percentile, ms | worst, ms |\n|---|---|---|---|")
    for station, late in found.items():
        parts = [percentile(late, 0.5), percentile(late, 0.95), max(late, default=float("nan"))]
        print(f"| {station} | " + " | ".join(f"{part:.0f}" for part in parts) + " |")
    p95 = percentile(found[stations[3]], 0.95) / 1000
    print(
        f"  {'ok ' if p95 < TARGET else 'NO '} to the screen, p95 {p95:.3f} s (must < {TARGET}); {spread(screens)} ms"
    )


def _note(heard: list[tuple[Key, float]], pose: Any) -> None:
    heard.append((_key(pose.x, pose.y, pose.yaw), time.time()))


class Program:
    """At the WebSocket: each pose, with the time."""

    def __init__(self, url: str) -> None:
        self._url = url.replace("http", "ws", 1) + "api/v1/live"
        self.heard: list[tuple[Key, float]] = []

    def __enter__(self) -> Program:
        from websockets.sync.client import connect

        self._socket = connect(self._url, max_queue=None, compression=None, close_timeout=1)
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()
        self._thread.join(10)

    def _read(self) -> None:
        for number, data in enumerate(self._socket, 1):
            at = time.time()
            self._socket.send(json.dumps({"t": "ack", "n": number}))
            if isinstance(data, str) and data.startswith('{"t":"pose"'):
                pose = json.loads(data)
                self.heard.append((_key(pose["x"], pose["y"], pose["theta"]), at))


def row_viewers(args: Any, server: Server, sim: Simulator) -> None:
    async def measured(viewers: int, camera: str | None) -> tuple[float, float]:
        """Percent of a core, kB a second and viewer."""
        counts = [0] * viewers
        url = server.url.replace("http", "ws", 1) + "api/v1/live"
        tasks = [asyncio.ensure_future(_view(url, camera, counts, index)) for index in range(viewers)]
        await asyncio.sleep(3.0)
        before, began, counted = server.processor, time.perf_counter(), sum(counts)
        await asyncio.sleep(args.seconds)
        used, passed = server.processor - before, time.perf_counter() - began
        for task in tasks:
            task.cancel()
        for outcome in await asyncio.gather(*tasks, return_exceptions=True):
            assert isinstance(outcome, asyncio.CancelledError), outcome
        return 100 * used / passed, (sum(counts) - counted) / passed / 1000 / max(1, viewers)

    columns = ("processor of the server, % of a core", "for each viewer, kB/s")
    found = Figures(columns)
    cases: list[tuple[int, str | None]] = [(0, None)]
    cases += [(int(number), camera) for camera in (None, "color") for number in args.viewers.split(",")]
    with moving(sim.uri):
        for _ in range(args.rounds):
            for viewers, camera in cases:
                percent, kilobytes = asyncio.run(measured(viewers, camera))
                name = f"{viewers or 'no'} viewer{'s' * (viewers > 1)}{', camera' * bool(camera)}"
                print(f"  {name:24} {percent:5.1f} %, {kilobytes:6.1f} kB/s", flush=True)
                found.note(name, columns[0], percent)
                if viewers:
                    found.note(name, columns[1], kilobytes)
    found.print()


def row_stops(args: Any, server: Server, sim: Simulator) -> None:
    async def measured(viewers: int) -> list[float]:
        counts = [0] * viewers
        url = server.url.replace("http", "ws", 1) + "api/v1/live"
        tasks = [asyncio.ensure_future(_view(url, None, counts, index)) for index in range(viewers)]
        while not all(counts):
            await asyncio.sleep(0.1)
        took = [await asyncio.to_thread(_stop, server.url) for _ in range(10)]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        return took

    column = "stop answered, ms"
    found = Figures([column])
    for _ in range(args.rounds):
        for viewers in (0, *map(int, args.viewers.split(","))):
            for took in asyncio.run(measured(viewers)):
                found.note(f"{viewers or 'no'} viewer{'s' * (viewers > 1)}", column, took)
    found.print()


def _stop(url: str) -> float:
    began = time.perf_counter()
    with urllib.request.urlopen(
        urllib.request.Request(f"{url}api/v1/stop", method="POST"), timeout=60
    ) as reply:
        assert json.load(reply)["stands_still"] is True
    return 1000 * (time.perf_counter() - began)


async def _view(url: str, camera: str | None, counts: list[int], index: int) -> None:
    from websockets.asyncio.client import connect

    async with connect(url, max_size=None, compression=None, close_timeout=1) as socket:
        await socket.send(json.dumps({"t": "look", "camera": camera, "costmap": False}))
        number = 0
        async for data in socket:
            number += 1
            counts[index] += len(data) if isinstance(data, bytes) else len(data.encode())
            await socket.send(json.dumps({"t": "ack", "n": number}))
