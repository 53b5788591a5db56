"""Clients of the Robot API that drive and fail, or stop beside a flood: seconds until the robot stands.

    python -m tests.benchmarks api_stops [--trials 50] [--only silent,gone,reset,cut,killed,stopped,zero,zero-flood,cancel,cancel-flood]

The simulated chassis turns at 0.5 rad/s (which it leaves within 0.4 s of a zero) and drives on when velocities end. Each row has
the median and the longest of all trials:

* silent, gone, reset, cut, killed, stopped: from the moment the client fails until the robot stands; zero is promised after 0.5 s.
* zero, cancel: from the request of a client until the robot stands, and until the answer; with "-flood" beside two clients that send
  velocities, tasks and cancels and read no answer.
"""

from __future__ import annotations

import argparse
import json
import signal
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rosproto import Node
from rosproto.gateway import Access
from tests.support.api_driver import TWIST, ApiDriver
from tests.support.driving_commands import moving
from tests.support.proxy import FaultProxy
from tests.support.robot_api import ApiClient
from tests.support.waiting import until
from woosh_pure import SimulatedChassis
from woosh_pure.api_server import RobotApiServer, simulated_site

CALL, ORDER, TASK = "woosh.ros.CallAction", "woosh.robot.ActionOrder", "woosh.robot.ExecTask"
FAILS: dict[str, Callable[[ApiDriver, FaultProxy], object]] = {
    "silent": lambda driver, proxy: driver.fall_silent(),
    "gone": lambda driver, proxy: driver.client.close_socket(),
    "reset": lambda driver, proxy: proxy.reset(),
    "cut": lambda driver, proxy: proxy.stall(),
}
SIGNALS = {"killed": "SIGKILL", "stopped": "SIGSTOP"}
STOPS = ("zero", "zero-flood", "cancel", "cancel-flood")
FLOODERS = 2


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks api_stops")
    parser.add_argument("--trials", type=int, default=50)
    parser.add_argument("--only", default=",".join((*FAILS, *SIGNALS, *STOPS)))
    args = parser.parse_args(arguments)
    with (
        SimulatedChassis(full_graph=False) as sim,
        Node("robot_api", master_uri=sim.master_uri, rosout=False) as node,
        RobotApiServer(node, port=0, access=Access(write=["api:*"]), site=simulated_site(sim)) as server,
    ):
        for way in args.only.split(","):
            trial = stopped if way in STOPS else signalled if way in SIGNALS else failed
            took, answered, missing = [], [], 0
            with flooding(server.url, way.endswith("-flood")):
                for _ in range(args.trials):
                    try:
                        seconds, answer = trial(sim, server, way)
                    except AssertionError as problem:
                        missing += 1
                        print(f"{way}: {problem}", flush=True)
                        sim.reset()
                        continue
                    took.append(seconds)
                    answered.append(answer)
            told = f"{way}, {len(took)} of {args.trials} trials: stands after {figures(took)}"
            print(told + (f", answer after {figures(answered)}" if way in STOPS else ""), flush=True)
            if missing:
                print(f"{way}: {missing} trials without a standing robot", flush=True)


def figures(took: list[float]) -> str:
    return f"{statistics.median(took):.2f} (longest {max(took):.2f}) s" if took else "-"


def standing(sim: SimulatedChassis, began: float) -> float:
    until(lambda: not moving(sim), 30.0, "the robot stands")
    return time.monotonic() - began


def turning(sim: SimulatedChassis) -> None:
    until(lambda: moving(sim), 20.0, "the robot moves")
    time.sleep(0.3)  # at its full speed


def failed(sim: SimulatedChassis, server: RobotApiServer, way: str) -> tuple[float, float]:
    with FaultProxy("127.0.0.1", server.port) as proxy:
        driver = ApiDriver(f"ws://127.0.0.1:{proxy.port}", 0.0, 0.5)
        with driver:
            turning(sim)
            began = time.monotonic()
            FAILS[way](driver, proxy)
            seconds = standing(sim, began)
            proxy.close()
    return seconds, 0.0


def signalled(sim: SimulatedChassis, server: RobotApiServer, way: str) -> tuple[float, float]:
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.support.api_driver", server.url, "0", "0.5"],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        turning(sim)
        began = time.monotonic()
        process.send_signal(getattr(signal, SIGNALS[way]))
        return standing(sim, began), 0.0
    finally:
        process.kill()
        process.communicate(timeout=10)


def stopped(sim: SimulatedChassis, server: RobotApiServer, way: str) -> tuple[float, float]:
    with ApiClient(server.url) as client:
        if way.startswith("zero"):
            full = time.monotonic() + 20.0
            while time.monotonic() < full:
                if client.answer({"type": TWIST, "body": {"angular": 0.5}})["ok"] and moving(sim):
                    full = min(full, time.monotonic() + 0.5)
                time.sleep(0.05)
            stop = {"type": TWIST}
        else:
            step = {"steps": [{"mode": 2, "value": 60.0, "speed": 0.5}], "action": 1}
            until(lambda: client.answer({"type": CALL, "body": {"stepControl": step}})["ok"])
            turning(sim)
            stop = {"type": CALL, "body": {"stepControl": {"action": 0}}}
        began = time.monotonic()
        client.answer(stop, 30.0)
        answer = time.monotonic() - began
        return standing(sim, began), answer


@contextmanager
def flooding(url: str, wanted: bool) -> Iterator[None]:
    """Clients that send without a pause and never read; nothing of it moves the robot."""
    over = threading.Event()
    frames = [
        json.dumps(frame)
        for frame in (
            {"type": TWIST, "body": {"linear": 1.5}},  # above the limit
            {"type": TASK, "body": {"markNo": "nowhere", "taskId": 1}},
            {"type": ORDER, "body": {"order": 3}},
            {"type": CALL, "body": {"moveBase": {"action": 1}}},
        )
    ]

    def flood() -> None:
        while not over.is_set():
            try:
                with ApiClient(url) as client:
                    while not over.is_set():
                        for frame in frames:
                            client.send(frame)
            except Exception:  # answers wait that are not read: it is disconnected, and comes again
                continue

    threads = [threading.Thread(target=flood, daemon=True) for _ in range(FLOODERS if wanted else 0)]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        over.set()
        for thread in threads:
            thread.join(10.0)
