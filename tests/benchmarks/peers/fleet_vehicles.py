"""Vehicles of ours for `tests.benchmarks fleet`, in a process of their own: N, "light" or "real", the broker's URL.

A stand-in for a chassis tells its pose and velocity ten times a second and drives 1 m/s in a straight line; one
thread moves all of them. With "real" each is a whole `Chassis` on a simulated one in another process. What
happens when is said at the end of the run, by the clock that all processes have in common.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace
from typing import Any

RATE = 10.0  # a second
SPEED = 1.0  # m/s
SIMULATORS = """
import sys
from contextlib import ExitStack
from woosh_pure import SimulatedChassis
with ExitStack() as stack:
    for _ in range(int(sys.argv[1])):
        print(stack.enter_context(SimulatedChassis(speed=1.0)).master_uri, flush=True)
    sys.stdin.read()
"""


class Feed:
    """What `Chassis.pose` and its like are to a vehicle."""

    def __init__(self, value: Any = None) -> None:
        self.listeners: list[Callable[[Any], object]] = []
        self.known = None if value is None else SimpleNamespace(value=value)

    def on(self, listener: Callable[[Any], object], *, connect: bool = True) -> Callable[[], None]:
        self.listeners.append(listener)
        if self.known is not None:
            listener(self.known.value)
        return lambda: self.listeners.remove(listener)

    def tell(self, value: Any) -> None:
        for listener in self.listeners:
            listener(value)


class Handle:
    def __init__(self, x: float, y: float) -> None:
        self.goal = (x, y)
        self._ended = threading.Event()
        self.arrived = False

    @property
    def done(self) -> bool:
        return self._ended.is_set()

    def end(self, arrived: bool) -> None:
        self.arrived = arrived
        self._ended.set()

    def cancel(self) -> None:
        self.end(False)

    def wait(self, timeout: float | None, *, raises: bool = True) -> Any:
        self._ended.wait(timeout)
        return SimpleNamespace(arrived=self.arrived, text="", kind="ended")


class LightChassis:
    """As much of a `Chassis` as a vehicle touches."""

    master_uri = "light"
    faults = ()

    def __init__(self, y: float) -> None:
        from woosh_pure.geometry import Pose2D, Velocity
        from woosh_pure.lease import ChassisLease

        self._pose_type, self._velocity_type = Pose2D, Velocity
        self.lease = ChassisLease()
        self.x, self.y = 0.0, y
        self.pose, self.measured_velocity, self.status_code = Feed(), Feed(), Feed()
        self.battery = Feed(SimpleNamespace(percent=80, voltage=48.0, charging=False))
        self.parameters = Feed(SimpleNamespace(max_linear=1.5, max_angular=1.5))
        self.status = Feed(SimpleNamespace(robot_mode=1))
        self.drive: Handle | None = None

    def readiness(self) -> Any:
        return SimpleNamespace(reasons=(), refuses=False, sentence=lambda: "")

    def go_to(self, x: float, y: float, yaw: float, **options: Any) -> Handle:
        before, self.drive = self.drive, Handle(x, y)
        found = self.drive
        if before is not None:
            before.end(False)
        return found

    def set_navigation_mode(self, *given: Any, **options: Any) -> None:
        pass

    def stop(self, **options: Any) -> Any:
        return SimpleNamespace(sentence=lambda: "")

    def step(self, seconds: float) -> None:
        drive, speed = self.drive, 0.0
        if drive is not None and not drive.done:
            dx, dy = drive.goal[0] - self.x, drive.goal[1] - self.y
            left = math.hypot(dx, dy)
            part = 1.0 if left <= SPEED * seconds else SPEED * seconds / left
            self.x, self.y = self.x + part * dx, self.y + part * dy
            speed = 0.0 if part == 1.0 else SPEED
        self.pose.tell(self._pose_type(self.x, self.y, 0.0))
        self.measured_velocity.tell(self._velocity_type(speed, 0.0, 0.0))
        if drive is not None and not drive.done and not speed:
            drive.end(True)


def main(size: str, kind: str, url: str) -> None:
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
            threading.Thread(target=tick, args=(chassis,), daemon=True).start()
        __import__("paho.mqtt.client")  # all is loaded before memory is counted
        print("standing", flush=True)
        sys.stdin.readline()
        chassis += [stack.enter_context(Chassis(uri)) for uri in uris]
        for number, each in enumerate(chassis):
            serial = f"v{number}"
            config = VehicleConfig(manufacturer="Woosh", serial=serial, map_id="hall")
            vehicle = Vehicle(each, config, Broker(url), Store(folder, "Woosh", serial))
            watch(vehicle, each, serial, log, real=kind == "real")
            stack.enter_context(vehicle)
        print("open", flush=True)
        for line in sys.stdin:
            if line.strip() == "log":
                for entry in log:
                    print(json.dumps(entry))
                log.clear()
                print("logged", flush=True)


def tick(chassis: list[LightChassis]) -> None:
    """Each its turn, evenly spread: robots do not tell their poses in step."""
    pause, due = 1.0 / RATE / len(chassis), time.monotonic()
    while True:
        for each in chassis:
            each.step(1.0 / RATE)
            due += pause
            time.sleep(max(0.0, due - time.monotonic()))


def watch(vehicle: Any, chassis: Any, serial: str, log: list[dict[str, Any]], *, real: bool) -> None:
    """Note when an order sets the robot moving, and when it has arrived at the last node."""
    machine, seen = vehicle._machine, {""}

    def note(event: str) -> None:
        log.append({"event": event, "serial": serial, "order": machine.order_id, "at": time.monotonic()})

    def moves() -> None:
        if machine.order_id not in seen:
            seen.add(machine.order_id)
            note("motion")

    if real:
        chassis.measured_velocity.on(
            lambda v: moves() if abs(v.vx) + abs(v.wz) > 0.01 and machine.driving else None, connect=False
        )
    else:
        go_to = chassis.go_to

        def begin(*given: Any, **options: Any) -> Any:
            moves()
            return go_to(*given, **options)

        chassis.go_to = begin
    ended = vehicle._driver._ended

    def over(token: int, arrived: bool, text: str) -> None:
        if arrived and len(machine.nodes) == 1:
            note("arrival")
        ended(token, arrived, text)

    vehicle._driver._ended = over


if __name__ == "__main__":
    sys.path.insert(0, os.environ["PYTHONPATH"])
    main(*sys.argv[1:])
