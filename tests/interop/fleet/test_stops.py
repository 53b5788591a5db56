"""A STOP by somebody else holds the order: the robot goes on only when the fleet manager asks for it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.fleet_master import Master, errors, order_over, statuses
from tests.support.mosquitto import mosquitto
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.fleet import Broker, Vehicle, VehicleConfig
from woosh_pure.fleet.order.transition import RETRIES

pytestmark = [pytest.mark.interop, pytest.mark.slow]
pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
WATCH = RETRIES[0] + 1.5
"""Seconds for which nothing may move; a failed drive is tried again earlier."""


class Hall:
    """A simulated chassis under a fleet manager."""

    def __init__(self, sim: SimulatedChassis, chassis: Chassis, master: Master, vehicle: Vehicle) -> None:
        self.sim, self.chassis, self.master, self.vehicle = sim, chassis, master, vehicle

    def stop(self) -> None:
        """As the page's STOP or another part of this process."""
        assert self.chassis.stop(everything=True).standing

    def stop_elsewhere(self) -> None:
        """As `woosh stop` on another computer."""
        with Chassis(self.sim.master_uri) as other:
            assert other.stop(everything=True).standing

    def watch(self) -> list[str]:
        """What moves within `WATCH` seconds."""
        found, end = [], time.monotonic() + WATCH
        while time.monotonic() < end:
            with self.sim.lock:
                motion = self.sim.world.motion
            if motion is not None:
                found.append(repr(motion))
            time.sleep(0.02)
        return found


@pytest.fixture
def hall(tmp_path: Path) -> Iterator[Hall]:
    config = VehicleConfig(manufacturer="Woosh", serial="A-17", map_id="hall", triggers={"button": ""})
    with (
        mosquitto(tmp_path) as broker,
        SimulatedChassis(speed=1) as sim,
        Chassis(sim.master_uri) as chassis,
        Master(broker.port) as master,
        Vehicle(chassis, config, Broker(broker.url)) as vehicle,
    ):
        master.until(lambda s: s["agvPosition"]["positionInitialized"] and s["operatingMode"] == "AUTOMATIC")
        yield Hall(sim, chassis, master, vehicle)


@pytest.mark.promise("a STOP while a fleet manager's order is carried out")
@pytest.mark.parametrize("stop", [Hall.stop, Hall.stop_elsewhere], ids=["this process", "another program"])
@pytest.mark.parametrize("answer", ["stopPause", "cancelOrder"])
def test_after_a_stop_the_robot_waits_for_the_fleet_manager(
    hall: Hall, stop: Callable[[Hall], None], answer: str
) -> None:
    """The state is paused and names the stop; stopPause drives on, after cancelOrder a new order does."""
    master = hall.master
    master.send("order", order_over("one", "n1 n2 n3"))
    master.until(lambda s: s["driving"])
    stop(hall)
    found = master.until(lambda s: "orderHeld" in errors(s) and not s["driving"])
    assert found["paused"]
    assert "somebody stopped the robot" in str(found["errors"])
    assert "driveError" not in errors(found)
    assert not hall.watch()
    master.instant("x", answer)
    if answer == "cancelOrder":
        master.until(lambda s: statuses(s).get("x") == "FINISHED")
        master.send("order", order_over("two", "n1 n2" if found["lastNodeId"] == "n1" else "n2 n3"))
    found = master.until(lambda s: s["driving"])
    assert not found["paused"]
    assert "orderHeld" not in errors(found)


@pytest.mark.promise("a STOP while a fleet manager's order is carried out")
def test_after_a_stop_during_an_action_the_next_drive_does_not_begin(hall: Hall) -> None:
    """No drive was under way that the stop could have ended."""
    master = hall.master
    blocks: dict[str, Any] = {
        "actionId": "a", "actionType": "waitForTrigger", "blockingType": "HARD",
        "actionParameters": [{"key": "triggerType", "value": "button"}],
    }  # fmt: skip
    master.send("order", order_over("one", "n1 n2", actions={"n1": [blocks]}))
    master.until(lambda s: statuses(s).get("a") == "RUNNING")
    hall.stop()
    assert hall.vehicle.trigger("button") == 1
    found = master.until(lambda s: statuses(s).get("a") == "FINISHED")
    assert found["paused"]
    assert "orderHeld" in errors(found)
    assert not hall.watch()
    master.instant("x", "stopPause")
    master.until(lambda s: s["driving"] and not s["paused"])


def test_a_stop_without_an_order_holds_nothing(hall: Hall) -> None:
    """An order is asked for after it."""
    hall.stop()
    hall.master.send("order", order_over("one", "n1 n2"))
    found = hall.master.until(lambda s: s["driving"])
    assert not found["paused"]
    assert errors(found) == []
