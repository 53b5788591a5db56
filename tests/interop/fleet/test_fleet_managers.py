"""Fleet managers of others, unmodified, drive `woosh vda5050` through Debian's mosquitto."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.support.extras import needs
from tests.support.fleet_maps import packed, serving
from tests.support.fleet_peers import javascript, python, vehicle
from tests.support.mosquitto import mosquitto
from woosh_pure.geometry import Pose2D
from woosh_pure.maps import GridMap

needs("fleet")

pytestmark = [pytest.mark.interop, pytest.mark.slow, pytest.mark.timeout(300)]
HERE = Path(__file__).resolve().parent
LIMIT = 240.0
"""Seconds for a manager, which needs 20: no promise of time, and the simulated robot drives as slowly as the computer
computes."""
BEEP = ("--action", "beep=!echo beep")
FULL = (
    "--charger", "C1", "--undock=-0.5", "--trigger", "button=!true", "--zone-set", "zones-1", "--footprint",
    "0.4,0.3 -0.4,0.3 -0.4,-0.3 0.4,-0.3",
)  # fmt: skip
"""Whatever a factsheet may tell, so that the managers look at it, too."""


def test_the_master_controller_of_vda_5050_lib_drives_it(tmp_path: Path) -> None:
    """Version 2.0: an order with a horizon, its update on the way, actions, a cancel, a second one, a far order."""
    with mosquitto(tmp_path) as broker, vehicle(broker.url, tmp_path, "--version", "2.0.0", *BEEP, *FULL):
        said = javascript(HERE / "master.js", BROKER=broker.url).run(LIMIT)
    orders = {(each["orderId"], each["update"]): each for each in said if each["event"] == "order"}
    assert orders["one", 1]["error"] is None
    assert orders["one", 1]["last"] == "n3"
    assert [each["node"] for each in said if each["event"] == "node" and each["orderId"] == "one"][-1] == "n3"
    ends = {each["id"]: each["status"] for each in said if each["event"] == "action"}
    assert {ends[name] for name in ("one-a", "one-b", "one-c")} == {"FINISHED"}
    assert orders["two", 0]["cancelled"]
    assert orders["far", 0]["error"] == "noRouteError"
    instants = [(e["id"], e["status"], e["error"]) for e in said if e["event"] == "instant"]
    assert ("cancel-1", "FINISHED", None) in instants
    assert ("cancel-2", "FAILED", "noOrderToCancel") in instants


def test_the_master_client_of_vda5050_sdk_drives_it(tmp_path: Path) -> None:
    """Version 2.1, every message by its schemas: an order with actions, a pause, a cancel, a second one."""
    with mosquitto(tmp_path) as broker, vehicle(broker.url, tmp_path, *BEEP, *FULL, "--maps"):
        said = python(HERE / "manager.py", BROKER=broker.url).run(LIMIT)
    assert said[-1] == {"event": "done"}
    assert [each for each in said if each["event"] == "complaint"] == []
    assert {"event": "connection", "state": "ONLINE"} in said
    assert any(each["event"] == "factsheet" for each in said)
    states = [each for each in said if each["event"] == "state" and each["order"] == "one"]
    visited = list(dict.fromkeys(each["last"] for each in states))
    assert visited == ["n1", "n2", "n3"]


def test_the_master_client_of_vda5050_sdk_brings_a_map_and_sends_it_there(tmp_path: Path) -> None:
    """downloadMap, enableMap, deleteMap, an order that says no way to its other map, and one that does."""
    archive = tmp_path / "up.zip"
    floor = GridMap(np.zeros((100, 100), np.int8), 0.1, Pose2D(-5.0, -5.0))
    archive.write_bytes(packed(tmp_path / "up", floor))
    with (
        mosquitto(tmp_path) as broker,
        serving(archive.read_bytes()) as address,
        vehicle(broker.url, tmp_path, "--maps"),
    ):
        given = {"BROKER": broker.url, "LINK": f"{address}/good.zip", "ARCHIVE": str(archive)}
        said = python(HERE / "map_manager.py", **given).run(LIMIT)
    assert said[-1] == {"event": "done"}
    assert [each for each in said if each["event"] == "complaint"] == []
    assert [each["text"] for each in said if each["event"] == "held back"] == [
        "maps not ready on vehicle: up"
    ]
    assert {each["id"]: each["status"] for each in said if each["event"] == "action"} == {
        "downloadMap-up-1": "FINISHED", "downloadMap-up-2": "FINISHED", "enableMap-up-1": "FINISHED",
        "enableMap-up-2": "FINISHED", "deleteMap-up-1": "FINISHED", "delete-enabled": "FAILED",
    }  # fmt: skip
    states = [each for each in said if each["event"] == "state"]
    assert states[-1]["maps"] == {"hall 1": "ENABLED", "up 2": "ENABLED"}
    assert states[-1]["map"] == "up"
    assert all(each["map"] == "hall" for each in states if "up-lift" not in each["actions"])
    assert states[-1]["actions"]["up-lift"] == "FINISHED"
    assert "no-lift" not in {each["order"] for each in states}
