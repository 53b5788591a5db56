"""A robot that drives on is reported as such; cancel and pause are FINISHED only when it stands."""

from __future__ import annotations

import threading
import time
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.fleet_master import Master, errors, order_over, statuses
from tests.support.light_chassis import LightChassis, moving
from tests.support.mosquitto import mosquitto
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.enums import NavigationMode
from woosh_pure.feed import feed
from woosh_pure.fleet import Broker, Vehicle, VehicleConfig

pytestmark = [pytest.mark.interop, pytest.mark.slow]
pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
CONFIG = VehicleConfig(manufacturer="Woosh", serial="A-17", map_id="hall")


@pytest.fixture
def hall(tmp_path: Path) -> Iterator[tuple[SimulatedChassis, Master]]:
    with (
        mosquitto(tmp_path) as broker,
        SimulatedChassis(speed=1) as sim,
        Chassis(sim.master_uri) as chassis,
        Master(broker.port) as master,
        Vehicle(chassis, CONFIG, Broker(broker.url)),
    ):
        master.until(lambda s: s["agvPosition"]["positionInitialized"] and s["operatingMode"] == "AUTOMATIC")
        yield sim, master


def moves(sim: SimulatedChassis) -> bool:
    with sim.lock:
        return not sim.world.body.velocity.is_standing()


@pytest.mark.parametrize("kind", ["cancelOrder", "startPause"])
def test_what_stops_is_finished_when_a_lost_robot_was_heard_to_stand(hall: Any, kind: str) -> None:
    """The link is cut under way: the stop runs, nothing is claimed meanwhile, and afterwards the robot stands."""
    sim, master = hall
    master.send("order", order_over("one", "n1 n2 n3"))
    until(lambda: moves(sim), 30.0, "the drive")  # `driving` is also said of a robot that is not heard
    sim.drop_link(300.0)
    master.until(lambda s: "robotLost" in errors(s))
    master.instant("x", kind)
    found = master.until(lambda s: "x" in statuses(s) and "robotLost" in errors(s))
    assert found["driving"]
    assert not found["agvPosition"]["positionInitialized"]
    assert {statuses(state)["x"] for state in master.all() if "x" in statuses(state)} == {"RUNNING"}
    sim.network.restore()
    deadline = time.monotonic() + 60.0
    while True:
        found = master.until(lambda s: True)
        if statuses(found)["x"] == "FINISHED":
            break
        assert time.monotonic() < deadline, found
        time.sleep(0.02)
    assert not moves(sim)
    assert "robotLost" not in errors(found)
    time.sleep(1.0)
    assert not moves(sim)


def test_the_speed_of_an_edge_is_set_before_each_drive(hall: Any) -> None:
    """Another program has taken it away in between."""
    sim, master = hall
    with Chassis(sim.master_uri) as other:
        master.send("order", order_over("one", "n1 n2", edge={"maxSpeed": 0.25}))
        master.until(lambda s: s["lastNodeId"] == "n2" and not s["nodeStates"], 60.0)
        other.set_navigation_mode(NavigationMode.PRECISE_AVOIDANCE, max_speed=0.0)
        master.send("order", order_over("two", "n2 n3", edge={"maxSpeed": 0.25}))
        master.until(lambda s: s["orderId"] == "two" and s["driving"])
        until(lambda: moves(sim), 30.0, "the drive")  # `driving` is also said of a robot that is not heard
        with sim.lock:
            assert sim.world.navigation.max_speed == pytest.approx(0.25)


def test_a_chassis_that_drives_faster_than_its_edge_allows_is_halted(tmp_path: Path) -> None:
    """At once as speedExceeded; the drive has failed, and is tried again later."""
    chassis = LightChassis(speed=0.4)  # whatever was set
    with (
        mosquitto(tmp_path) as broker,
        Master(broker.port) as master,
        moving([chassis]),
        Vehicle(chassis, CONFIG, Broker(broker.url)),  # type: ignore[arg-type]
    ):
        master.until(lambda s: s["operatingMode"] == "AUTOMATIC" and s["agvPosition"]["positionInitialized"])
        master.send("order", order_over("one", "n1 n3", edge={"maxSpeed": 0.25}))
        found = master.until(lambda s: "speedExceeded" in errors(s))
        assert "0.40 m/s, and edge n1n3 allows 0.25 m/s" in str(found["errors"])
        master.until(lambda s: "driveError" in errors(s) and not s["driving"])
        assert chassis.x < 2.9


def test_velocities_that_may_be_older_than_the_stop_do_not_show_that_it_stands(
    hall: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Zeros arrive after the drive has ended; the pause is FINISHED when the robot has sent some through a
    connection that was made after it."""
    sim, master = hall
    reachable, real = threading.Event(), feed.fresh_messages

    def fresh_messages(*given: Any) -> Generator[Any, None, None]:
        if reachable.is_set():
            yield from real(*given)

    monkeypatch.setattr(feed, "fresh_messages", fresh_messages)
    master.send("order", order_over("one", "n1 n2 n3"))
    master.until(lambda s: s["driving"])
    master.instant("x", "startPause")
    master.until(lambda s: not s["driving"])
    assert sim_stands_for(sim, 1.5)
    assert statuses(master.all()[-1])["x"] == "RUNNING"
    reachable.set()
    master.until(lambda s: statuses(s)["x"] == "FINISHED")


def sim_stands_for(sim: SimulatedChassis, seconds: float) -> bool:
    """Whether it stands within 10 s, and then for so long."""
    until(lambda: not moves(sim), 10.0)
    time.sleep(seconds)
    return not moves(sim)
