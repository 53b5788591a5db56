"""A robot that has only the Robot API: seconds until it stands, when what commands it fails.

    python -m tests.benchmarks api_bridge [--trials 50] [--only ROW,...]

A program with a `Chassis` of the simulated robot's Robot API drives by velocity, or has a task; what a drive sends is carried on when
it ends, so that only a zero ends it. Each row has the median and the longest of all trials:

* killed: kill -9 with a watchdog; unwatched: without one. In a drive the server's own zero, which follows its client's end, is as early.
* watchdog: kill -9 together with the server, which another one replaces: only the watchdog's zero can end the drive. nothing: the
  same without a watchdog; the robot has to move still after 5 s, which shows that nothing else ends it.
* cut-drive: the network delivers nothing more; reset-drive: the connection is reset.
* cut-task, reset-task: the same, and the program calls `stop` in that moment. The task goes on in the robot while it cannot be reached
  (3 s of a cut, which the trial checks), as a task of ROS 1 does. The time counts from when the network delivers again until the
  robot has ended the task; its braking comes on top.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import time
from contextlib import ExitStack

from rosproto import Node
from rosproto.gateway import Access
from tests.support.driving_commands import moving
from tests.support.proxy import FaultProxy
from tests.support.waiting import until
from woosh_pure import SimulatedChassis
from woosh_pure.api_server import RobotApiServer, simulated_site
from woosh_pure.enums import TaskState

WAYS = (
    "killed-drive",
    "killed-task",
    "unwatched-drive",
    "watchdog-drive",
    "nothing-drive",
    "cut-drive",
    "cut-task",
    "reset-drive",
    "reset-task",
)
WHAT = {"nothing-drive": "moves still", "cut-task": "the task has ended", "reset-task": "the task has ended"}
CUT_SECONDS, STILL_SECONDS = 3.0, 5.0
SERVER = """
import sys, time
from rosproto import Node
from rosproto.gateway import Access
from woosh_pure.api_server import RobotApiServer

with Node("first", master_uri=sys.argv[1], rosout=False) as node:
    with RobotApiServer(node, port=0, access=Access(write=["api:*"]), share=True) as server:
        print(server.port, flush=True)
        time.sleep(600)
"""
PROGRAM = """
import sys, time
from woosh_pure import Chassis

with Chassis(sys.argv[1], watchdog=sys.argv[2] == "watched") as chassis:
    if sys.argv[3] == "drive":
        with chassis.velocity(bypasses_protection=True) as drive:
            drive.hold(0.0, 0.4, seconds=60)
    else:
        chassis.go_to_mark("B2")
        sys.stdin.readline()
        chassis.stop(timeout=30)
"""


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks api_bridge")
    parser.add_argument("--trials", type=int, default=50)
    parser.add_argument("--only", default=",".join(WAYS))
    args = parser.parse_args(arguments)
    with (
        SimulatedChassis(full_graph=False) as sim,
        Node("robot_api", master_uri=sim.master_uri, rosout=False) as node,
        RobotApiServer(node, port=0, access=Access(write=["api:*"]), site=simulated_site(sim)) as server,
    ):
        for way in args.only.split(","):
            took = []
            for number in range(args.trials):
                sim.reset()
                try:
                    took.append(trial(sim, server, way))
                except AssertionError as problem:
                    print(f"{way}, trial {number + 1}: {problem}", flush=True)
            shown = f"{statistics.median(took):.2f} (longest {max(took):.2f}) s" if took else "-"
            what = WHAT.get(way, "stands")
            print(f"{way}, {len(took)} of {args.trials} trials: {what} after {shown}", flush=True)


def trial(sim: SimulatedChassis, server: RobotApiServer, way: str) -> float:
    fault, _, what = way.partition("-")
    with ExitStack() as stack:
        first = started(stack, SERVER, sim.master_uri) if fault in ("watchdog", "nothing") else None
        port = server.port if first is None or first.stdout is None else int(first.stdout.readline())
        proxy = stack.enter_context(FaultProxy("127.0.0.1", port))
        watched = "unwatched" if fault in ("unwatched", "nothing") else "watched"
        process = started(stack, PROGRAM, f"ws://127.0.0.1:{proxy.port}", watched, what)
        until(lambda: moving(sim), 30.0, "the robot moves")
        time.sleep(0.5)
        began = time.monotonic()
        if first is not None:
            proxy.retarget("127.0.0.1", server.port)
            first.kill()
        if first is not None or fault in ("killed", "unwatched"):
            process.kill()
        else:
            began = broken(sim, proxy, process, fault, what)
        if fault == "nothing":
            time.sleep(STILL_SECONDS)
            assert moving(sim), "the robot stands, although nothing sends zero"
            return time.monotonic() - began
        if what == "task":
            until(lambda: sim.world.status().task_state.is_final, 60.0, "the task has ended")
            assert sim.world.status().task_state is TaskState.CANCELLED, "the task was carried out to its end"
        ended = time.monotonic()
        until(lambda: not moving(sim), 60.0, "the robot stands")
        return (ended if what == "task" and fault in ("cut", "reset") else time.monotonic()) - began


def broken(
    sim: SimulatedChassis, proxy: FaultProxy, process: subprocess.Popen[str], fault: str, what: str
) -> float:
    """Break the network of a program; return the time from which it counts."""
    began = time.monotonic()
    if fault == "cut":
        proxy.stall()
    if what == "task":
        assert process.stdin is not None
        process.stdin.write("stop\n")
        process.stdin.flush()
    if fault == "cut":
        while (moving(sim) or what == "task") and time.monotonic() - began < CUT_SECONDS:
            time.sleep(0.01)
        if what == "task":
            assert moving(sim), "the task has not gone on"
            began = time.monotonic()
    proxy.reset()
    proxy.resume()
    return began


def started(stack: ExitStack, program: str, *words: str) -> subprocess.Popen[str]:
    """A program that ends with the stack."""
    process = subprocess.Popen(
        [sys.executable, "-c", program, *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    stack.callback(process.communicate, timeout=10)
    stack.callback(process.kill)
    return process
