"""What a vehicle does not obey, whatever it says: messages for others, and a kept order that is somebody else's."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.fleet_master import Master, errors, order_over
from tests.support.fleet_peers import ROOT
from tests.support.light_chassis import LightChassis, moving
from tests.support.mosquitto import mosquitto
from woosh_pure.fleet import Broker, Store, Vehicle, VehicleConfig

pytestmark = [pytest.mark.interop]
pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
CONFIG = VehicleConfig(manufacturer="Woosh", serial="A-17", map_id="hall")


@pytest.fixture
def master(tmp_path: Path) -> Iterator[Master]:
    chassis = LightChassis(speed=5.0)
    with (
        mosquitto(tmp_path) as broker,
        Master(broker.port) as master,
        moving([chassis]),
        Vehicle(chassis, CONFIG, Broker(broker.url)),  # type: ignore[arg-type]
    ):
        master.until(lambda s: s["operatingMode"] == "AUTOMATIC" and s["agvPosition"]["positionInitialized"])
        yield master


@pytest.mark.promise("serial number or major version, or with a key twice, is refused")
@pytest.mark.parametrize(
    ("field", "value"), [("manufacturer", "Other"), ("serialNumber", "A-18"), ("version", "3.0.0")]
)
def test_an_order_for_somebody_else_is_not_driven(master: Master, field: str, value: str) -> None:
    """On the vehicle's own topic: a validationError that names the field, and no order."""
    master.send("order", json.dumps({**order_over("one", "n1 n2"), field: value}))
    found = master.until(lambda s: errors(s) == ["validationError"])
    assert found["orderId"] == ""
    assert {"referenceKey": "field", "referenceValue": field} in found["errors"][0]["errorReferences"]


@pytest.mark.promise("serial number or major version, or with a key twice, is refused")
def test_an_order_with_a_key_twice_is_not_driven(master: Master) -> None:
    """The last one would release what the first one does not."""
    text = json.dumps(order_over("one", "n1 n2", released=1))
    master.send("order", text.replace('"released": false', '"released": false, "released": true'))
    found = master.until(lambda s: errors(s) == ["validationError"])
    assert found["orderId"] == ""
    assert "'released' comes twice" in found["errors"][0]["errorDescription"]


def test_a_second_process_with_the_same_folder_ends_with_a_sentence(tmp_path: Path) -> None:
    """The first one goes on; the second one moves nothing, and says what to do."""
    store = Store(tmp_path, "Woosh", "A-17")
    store.lock()
    words = ("vda5050", "--broker", "mqtt://127.0.0.1:1", "--serial", "A-17", "--state", str(tmp_path))
    command: list[Any] = [sys.executable, "-m", "woosh_pure", "--sim", *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60)
    store.unlock()
    assert done.returncode == 1
    assert "running already; end that one" in done.stderr
    assert "Traceback" not in done.stderr
