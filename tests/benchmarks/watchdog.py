"""Kill -9 of whoever drives: seconds until the robot is told to stop by the watchdog. `--trials N` of each (50), and
`--only NAME`, as often as wanted.

The time is taken at the robot, from the kill to the first zero velocity or cancel that comes. "Stall" is the longest
time for which a thread of this process that only sleeps was late in that trial: what an overloaded computer adds.
Then what the watchdog costs: the first motion and a later one with and without it, and its memory.
"""

from __future__ import annotations

import argparse
import os
import signal
import statistics
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rosproto.node import Node
from rosproto.watchdog import Watchdog
from tests.support.driving_commands import COMMANDS, children, driving, is_alive, moving
from woosh_pure import Chassis, SimulatedChassis

PROMISED = 0.5


class Stall:
    """How late a thread that sleeps 5 ms was at most."""

    def __init__(self) -> None:
        self.most = 0.0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Stall:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._over.is_set():
            before = time.monotonic()
            time.sleep(0.005)
            self.most = max(self.most, time.monotonic() - before - 0.005)


@contextmanager
def witness(sim: SimulatedChassis) -> Iterator[list[float]]:
    """Times at which the robot was told to stop: a zero, or the cancel of a goal."""
    told: list[float] = []

    def on_velocity(message: Any) -> None:
        if not (message.linear.x or message.angular.z):
            told.append(time.monotonic())

    with Node("/witness", master_uri=sim.master_uri, rosout=False) as node:
        node.subscriber("/smooth_cmd_vel", "geometry_msgs/Twist", on_velocity, queue_size=1000)
        for action in ("/move_base", "/cmd_vel_control"):
            node.subscriber(
                f"{action}/cancel", "actionlib_msgs/GoalID", lambda _: told.append(time.monotonic())
            )
        yield told


def trial(command: str, first: int) -> tuple[float, float]:
    """Seconds until it is told, infinite if it never is; and the longest stall.

    Args:
        command: Who drives.
        first: Signal of the kill; SIGSTOP is followed by nothing.
    """
    with (
        tempfile.TemporaryDirectory() as folder,
        SimulatedChassis(full_graph=False) as sim,
        witness(sim) as told,
        driving(command, sim, Path(folder)) as pid,
    ):
        (watchdog,) = children(pid)
        time.sleep(0.3)
        with Stall() as stall:
            told.clear()
            os.kill(pid, first)
            began = time.monotonic()
            while not told and moving(sim) and time.monotonic() < began + 10.0:
                time.sleep(0.002)
            took = (told[0] if told else time.monotonic()) - began
            if not told and moving(sim):
                took = float("inf")
        if first == signal.SIGKILL:
            while is_alive(watchdog):
                assert time.monotonic() < began + 30.0, "the watchdog has stayed behind"
                time.sleep(0.02)
    return took, stall.most


def run(options: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="watchdog")
    parser.add_argument("--trials", type=int, default=50)
    parser.add_argument("--only", action="append", choices=sorted(COMMANDS))
    parser.add_argument("--stop", action="store_true", help="SIGSTOP in place of SIGKILL")
    args = parser.parse_args(options)
    number = signal.SIGSTOP if args.stop else signal.SIGKILL
    limit = 0.8 + PROMISED if args.stop else PROMISED
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors; {number.name}")
    print(
        f"| who | trials | within {limit} s | median s | longest s | longest stall s |\n|---|---|---|---|---|---|"
    )
    for command in args.only or COMMANDS:
        seconds, stalls = zip(*(trial(command, number) for _ in range(args.trials)), strict=True)
        good = sum(took <= limit for took in seconds)
        print(
            f"| {command} | {len(seconds)} | {good} | {statistics.median(seconds):.3f} | {max(seconds):.3f} "
            f"| {max(stalls):.3f} |",
            flush=True,
        )
        for took, stall in zip(seconds, stalls, strict=True):
            if took > limit:
                print(f"late: {took:.3f} s, with a stall of {stall:.3f} s in that trial", flush=True)
    costs()
    return 0


def costs() -> None:
    """What it takes beside a motion that it watches."""
    print("\n| | without | with |\n|---|---|---|")
    with SimulatedChassis(full_graph=False) as sim:
        rows = []
        for watchdog in (False, True):
            with Chassis(sim.master_uri, watchdog=watchdog) as chassis:
                chassis.measured_velocity.wait(10.0)
                took = []
                for _ in range(6):
                    began = time.monotonic()
                    with chassis.velocity(bypasses_protection=True) as drive:
                        took.append(time.monotonic() - began)
                        drive.set(0.0)
                    time.sleep(0.5)
                rows.append((took[0], statistics.median(took[1:])))
        print(f"| first velocity block opens, s | {rows[0][0]:.3f} | {rows[1][0]:.3f} |")
        print(f"| a later one, s | {rows[0][1]:.3f} | {rows[1][1]:.3f} |")
    with Watchdog() as made:
        time.sleep(3.0)
        words = ["ps", "-o", "rss=,time=", "-p", str(made.pid)]
        print(f"\nThe process: {subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()} "
              "(KiB, processor time)")  # fmt: skip
