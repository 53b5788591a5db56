"""A stand-in for a chassis, without a network, with the interface that a vehicle of the fleet uses.

It reports its pose and velocity ten times a second, the minimum of a real one, and drives in a straight line.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

from woosh_pure.connection.call_scope import CallScope
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.lease import ChassisLease

__all__ = ["LightChassis", "moving"]

RATE = 10.0  # a second


class Feed:
    """A feed such as `Chassis.pose`."""

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
    """A drive."""

    def __init__(self, x: float, y: float) -> None:
        self.goal = (x, y)
        self._ended = threading.Event()
        self.arrived = False
        self.ended_at = 0.0

    @property
    def done(self) -> bool:
        return self._ended.is_set()

    def end(self, arrived: bool) -> None:
        if not self.done:
            self.arrived, self.ended_at = arrived, time.monotonic()
        self._ended.set()

    def cancel(self) -> None:
        self.end(False)

    def wait(self, timeout: float | None, *, raises: bool = True) -> Any:
        self._ended.wait(timeout)
        return SimpleNamespace(arrived=self.arrived, text="", kind="ended")


class LightChassis:
    """A chassis that stands at (0, y) until it gets a drive."""

    master_uri = "light"
    faults = ()
    node = SimpleNamespace(params={})  # no outline of a navigation
    _components = SimpleNamespace(feeds=SimpleNamespace(wait_standing=lambda *_, **__: True))

    def __init__(self, y: float = 0.0, speed: float = 1.0) -> None:
        self.lease = ChassisLease()
        self.x, self.y, self.speed = 0.0, y, speed
        self.pose, self.measured_velocity, self.status_code, self.plan = Feed(), Feed(), Feed(), Feed()
        self.battery = Feed(SimpleNamespace(percent=80, voltage=48.0, charging=False, measured=True))
        self.parameters = Feed(SimpleNamespace(max_linear=1.5, max_angular=1.5))
        self.status = Feed(SimpleNamespace(robot_mode=1))
        self.drive: Handle | None = None

    def feed(self, name: str) -> Feed:
        return {"plan": self.plan}[name]

    def readiness(self) -> Any:
        return SimpleNamespace(reasons=(), refuses=False, sentence=lambda: "")

    def request(self) -> CallScope:
        return CallScope()

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
            part = 1.0 if left <= self.speed * seconds else self.speed * seconds / left
            self.x, self.y = self.x + part * dx, self.y + part * dy
            speed = 0.0 if part == 1.0 else self.speed
        self.pose.tell(Pose2D(self.x, self.y, 0.0))
        self.measured_velocity.tell(Velocity(speed, 0.0, 0.0))
        if drive is not None and not drive.done and not speed:
            drive.end(True)


@contextmanager
def moving(chassis: list[LightChassis]) -> Iterator[None]:
    """Move all of them in one thread, evenly spread in time, because robots do not report in step."""
    ending = threading.Event()

    def tick() -> None:
        pause, due = 1.0 / RATE / len(chassis), time.monotonic()
        while not ending.is_set():
            for each in chassis:
                each.step(1.0 / RATE)
                due += pause
                ending.wait(max(0.0, due - time.monotonic()))

    thread = threading.Thread(target=tick, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ending.set()
        thread.join(5.0)
