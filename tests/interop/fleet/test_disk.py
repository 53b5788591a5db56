"""A failing disk: orders that cannot be saved are not acknowledged."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.fleet_master import Master, errors, order_over, statuses
from tests.support.light_chassis import LightChassis, moving
from tests.support.mosquitto import mosquitto
from woosh_pure.fleet import Broker, Store, Vehicle, VehicleConfig, vehicle

pytestmark = [pytest.mark.interop]
pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
BEGUN: list[str] = []


def beep(task: Any) -> None:
    """Notes that it ran."""
    BEGUN.append(task.action.id)


class Disk:
    """The folder of a vehicle; `full` makes every write to it fail with the system's own words.

    Changes are added to a file, and states are written beside it: the file itself becomes one that takes nothing, too.
    """

    def __init__(self, store: Store) -> None:
        self.path, self.beside = store.path, Path(f"{store.path}.new")
        self.aside = store.path.with_suffix(".aside")

    def full(self) -> None:
        self.beside.symlink_to("/dev/full")
        if self.path.exists():
            self.path.rename(self.aside)
            self.path.symlink_to("/dev/full")

    def free(self) -> None:
        self.beside.unlink()
        if self.path.is_symlink():
            self.aside.rename(self.path)


@pytest.fixture
def hall(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Master, Disk, Any]]:
    if not os.path.exists("/dev/full"):
        pytest.skip("this system has no /dev/full")
    monkeypatch.setattr(vehicle, "_DISK_SECONDS", 0.1)
    monkeypatch.setattr(vehicle, "_FACTS_SECONDS", 0.2)
    BEGUN.clear()
    config = VehicleConfig(
        manufacturer="Woosh", serial="A-17", map_id="hall", actions={"beep": f"{__name__}:beep"}
    )
    chassis, store = LightChassis(speed=5.0), Store(tmp_path / "state", "Woosh", "A-17")
    with mosquitto(tmp_path) as broker, Master(broker.port) as master, moving([chassis]):

        def opened() -> Vehicle:
            return Vehicle(chassis, config, Broker(broker.url), store)  # type: ignore[arg-type]

        yield master, Disk(store), opened


def free_again(master: Master, disk: Disk) -> None:
    disk.free()
    master.until(lambda s: "storageError" not in errors(s))


def action(name: str) -> dict[str, Any]:
    return {"actionId": name, "actionType": "beep", "blockingType": "HARD", "actionParameters": []}


def test_an_order_that_cannot_be_kept_is_not_taken(hall: Any) -> None:
    """orderError with the system's words, and storageError as FATAL; it is taken when there is room."""
    master, disk, opened = hall
    with opened():
        master.until(lambda s: s["operatingMode"] == "AUTOMATIC" and s["agvPosition"]["positionInitialized"])
        disk.full()
        master.send("order", order_over("one", "n1 n2"))
        found = master.until(lambda s: "orderError" in errors(s) and "storageError" in errors(s))
        assert found["orderId"] == ""
        assert "No space left" in str(found["errors"])
        assert [e["errorLevel"] for e in found["errors"] if e["errorType"] == "storageError"] == ["FATAL"]
        free_again(master, disk)
        master.send("order", order_over("one", "n1 n2"))
        master.until(lambda s: s["lastNodeId"] == "n2" and not s["nodeStates"])


def test_on_the_way_it_stands_at_the_next_node_and_no_action_begins(hall: Any) -> None:
    """It would begin again after a restart. With room it begins, once, and the order goes on."""
    master, disk, opened = hall
    with opened():
        master.until(lambda s: s["operatingMode"] == "AUTOMATIC" and s["agvPosition"]["positionInitialized"])
        master.send("order", order_over("one", "n1 n2 n3", actions={"n2": [action("b")]}))
        master.until(lambda s: s["driving"])
        disk.full()
        master.until(lambda s: s["lastNodeId"] == "n2" and not s["driving"] and "storageError" in errors(s))
        assert BEGUN == []
        free_again(master, disk)
        found = master.until(lambda s: s["lastNodeId"] == "n3" and not s["nodeStates"])
        assert statuses(found)["b"] == "FINISHED"
        assert BEGUN == ["b"]


def test_a_cancel_is_obeyed_without_a_disk(hall: Any) -> None:
    """To stand still is never refused; an action that waited for the disk does not begin afterwards."""
    master, disk, opened = hall
    with opened():
        master.until(lambda s: s["operatingMode"] == "AUTOMATIC" and s["agvPosition"]["positionInitialized"])
        master.send("order", order_over("one", "n1 n2 n3", actions={"n2": [action("b")]}))
        master.until(lambda s: s["driving"])
        disk.full()
        master.until(lambda s: s["lastNodeId"] == "n2" and not s["driving"] and "storageError" in errors(s))
        master.instant("stop", "cancelOrder")
        found = master.until(lambda s: statuses(s).get("stop") == "FINISHED" and not s["nodeStates"])
        assert statuses(found)["b"] == "FAILED"
        free_again(master, disk)
        assert BEGUN == []


def test_a_disk_that_is_full_from_the_start_is_told(hall: Any) -> None:
    """Before the first order."""
    master, disk, opened = hall
    disk.beside.parent.mkdir()
    disk.full()
    with opened():
        master.until(lambda s: "storageError" in errors(s))
        free_again(master, disk)
