"""Vehicles of ours for `tests.benchmarks fleet`, in a process of their own: N, "light" or "real", the broker's URL.

One thread moves all stand-ins (`tests/support/light_chassis.py`). With "real" each is a whole `Chassis` on a simulated one in another process. What
happens when is printed at the end of the run, by the clock that all processes share.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

LEGS = 3  # of each order, as in tests/benchmarks/fleet.py, which may be another checkout's
SIMULATORS = """
import sys
from contextlib import ExitStack
from woosh_pure import SimulatedChassis
with ExitStack() as stack:
    for _ in range(int(sys.argv[1])):
        print(stack.enter_context(SimulatedChassis(speed=1.0)).master_uri, flush=True)
    sys.stdin.read()
"""


def main(size: str, kind: str, url: str) -> None:
    from tests.support.light_chassis import LightChassis, moving
    from woosh_pure import Chassis
    from woosh_pure.fleet import Broker, Store, Vehicle, VehicleConfig

    log: list[dict[str, Any]] = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        chassis: list[Any]
        if kind == "real":
            command = [sys.executable, "-c", SIMULATORS, size]
            robots = stack.enter_context(
                subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            )
            assert robots.stdin is not None
            assert robots.stdout is not None
            stack.callback(robots.stdin.close)
            uris = [robots.stdout.readline().strip() for _ in range(int(size))]
            chassis = []
        else:
            uris = []
            chassis = [LightChassis(float(number)) for number in range(int(size))]
            stack.enter_context(moving(chassis))
        __import__("paho.mqtt.client")  # all is loaded before memory is counted
        print("standing", flush=True)
        sys.stdin.readline()
        chassis += [stack.enter_context(Chassis(uri)) for uri in uris]
        for number, each in enumerate(chassis):
            serial = f"v{number}"
            config = VehicleConfig(manufacturer="Woosh", serial=serial, map_id="hall")
            vehicle = Vehicle(each, config, Broker(url), Store(folder, "Woosh", serial))
            watch(each, serial, log, real=kind == "real")
            stack.enter_context(vehicle)
        print("open", flush=True)
        for line in sys.stdin:
            if line.strip() == "log":
                for entry in log:
                    print(json.dumps(entry))
                log.clear()
                print("logged", flush=True)


class WatchedGoal:
    """A goal of the chassis whose arrival is noted."""

    def __init__(self, goal: Any, arrived: Callable[[], None]) -> None:
        self._goal, self._arrived = goal, arrived
        self.cancel = goal.cancel

    def wait(self, timeout: float | None, *, raises: bool = True) -> Any:
        outcome = self._goal.wait(timeout, raises=raises)
        if outcome.arrived:
            self._arrived()
        return outcome


def watch(chassis: Any, serial: str, log: list[dict[str, Any]], *, real: bool) -> None:
    """Note when each order sets the robot moving, and when the robot has arrived at the order's last node.

    The orders are those of `Manager.send`: "o1" goes to x = LEGS, "o2" back to 0, and so on.
    """
    number, resting, still = 0, True, True
    go_to = chassis.go_to

    def note(event: str) -> None:
        log.append({"event": event, "serial": serial, "order": f"o{number}", "at": time.monotonic()})

    def moves() -> None:
        nonlocal still
        if still:
            still = False
            note("motion")

    def arrived() -> None:
        nonlocal resting
        resting = True
        note("arrival")

    def begin(x: float, *given: Any, **options: Any) -> Any:
        nonlocal number, resting, still
        if resting:
            number, resting, still = number + 1, False, True
        if not real:
            moves()
        goal = go_to(x, *given, **options)
        return WatchedGoal(goal, arrived) if x == (LEGS if number % 2 else 0.0) else goal

    chassis.go_to = begin
    if real:
        chassis.measured_velocity.on(
            lambda v: moves() if not resting and abs(v.vx) + abs(v.wz) > 0.01 else None, connect=False
        )


if __name__ == "__main__":
    sys.path.append(os.environ["FLEET_BENCHMARK"])  # what another checkout does not have of the tests
    main(*sys.argv[1:])
