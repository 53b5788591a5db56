"""One robot and one browser for the tests of a file: what is expensive is made once, and costs nothing afterwards."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.support.browser import opened
from woosh_pure import Chassis, SimulatedChassis

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from woosh_pure.web.server import WebServer


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Headless Chromium; each person in it has a context of its own.

    Not for longer than a file: while it is open an event loop runs in this thread, and `asyncio.run` of the
    tests that come between would be refused.
    """
    with opened() as one:
        yield one


class Robot:
    """The simulated chassis, and a page of it."""

    def __init__(self, sim: SimulatedChassis, chassis: Chassis, server: WebServer) -> None:
        self.sim, self.chassis, self.server = sim, chassis, server

    @property
    def url(self) -> str:
        return self.server.url

    @property
    def place(self) -> tuple[float, float]:
        pose = self.chassis.pose.wait(timeout=5.0)
        return pose.x, pose.y

    @property
    def speed(self) -> float:
        velocity = self.chassis.measured_velocity.wait(timeout=5.0)
        return abs(velocity.vx) + abs(velocity.wz)

    def away(self, x: float, y: float) -> float:
        here = self.place
        return math.hypot(here[0] - x, here[1] - y)

    def reset(self) -> None:
        """As it was in the beginning: it stands at its start, knows where it is, and nobody commands it."""
        if self.chassis.lease.holder is not None:
            self.chassis.lease.release(self.chassis.lease.holder)
        self.sim.reset()
        self.chassis.stop(everything=True, timeout=5.0)


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """The simulated hall at three times its speed, served."""
    for module in ("fastapi", "uvicorn", "websockets", "PIL"):
        pytest.importorskip(module, reason=f'{module} is not installed: pip install ".[web]"')
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    with SimulatedChassis(speed=3) as sim, Chassis(sim.master_uri) as chassis:
        app = web.app(
            {"sim": chassis},
            allow_driving=True,
            marks=marks(),
            recordings=tmp_path_factory.mktemp("recordings"),
            simulator=sim,
        )
        with WebServer(app, port=0) as server:
            yield Robot(sim, chassis, server)


@pytest.fixture
def robot(hall: Robot) -> Robot:
    """The robot of the hall, as it was in the beginning."""
    hall.reset()
    return hall


def marks() -> list[object]:
    """Those of the simulated hall."""
    from woosh_pure.maps.marks import UserMark
    from woosh_pure.sim.site import built_in_site

    return [UserMark(name, mark.pose, charger=mark.charger) for name, mark in built_in_site().marks.items()]
