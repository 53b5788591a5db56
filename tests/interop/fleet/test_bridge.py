"""Past one broker: a broker for the hall, a bridge to the manager's, as docs/fleet.md has it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.fleet_master import Master, came_back, order_over
from tests.support.light_chassis import LightChassis, moving
from tests.support.mosquitto import mosquitto
from woosh_pure.fleet import Broker, Vehicle, VehicleConfig

pytestmark = [pytest.mark.interop, pytest.mark.slow]
pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
PAGE = Path(__file__).resolve().parents[3] / "docs" / "fleet.md"
CONFIG = VehicleConfig(manufacturer="Woosh", serial="A-17", map_id="hall")


def bridge(port: int) -> str:
    """The lines of the page."""
    text = PAGE.read_text("utf-8").partition("        connection hall-1\n")
    lines = (text[1] + text[2]).partition("\n\n")[0]
    found = "\n".join(line.strip() for line in lines.splitlines())
    assert "address manager:1883" in found
    return found.replace("manager:1883", f"127.0.0.1:{port}")


def test_a_vehicle_behind_a_bridge_is_driven_as_one_in_front_of_it(tmp_path: Path) -> None:
    """Orders go in, states come out; ONLINE, CONNECTIONBROKEN and the factsheet are retained there."""
    (tmp_path / "manager").mkdir()
    chassis = LightChassis(speed=5.0)
    with (
        mosquitto(tmp_path / "manager") as central,
        mosquitto(tmp_path, f"allow_anonymous true\n{bridge(central.port)}") as hall,
        Master(central.port) as master,
        moving([chassis]),
        Vehicle(chassis, CONFIG, Broker(hall.url)) as ours,  # type: ignore[arg-type]
    ):
        master.until(lambda s: s["operatingMode"] == "AUTOMATIC" and s["agvPosition"]["positionInitialized"])
        master.send("order", order_over("one", "n1 n2 n3"))
        master.until(lambda s: s["lastNodeId"] == "n3" and not s["nodeStates"])
        ours._connection._client.socket().shutdown(2)
        master.until(lambda _: came_back(master), topic="connection")
        with Master(central.port) as late:
            assert late.until(lambda c: True, topic="connection")["connectionState"] == "ONLINE"
            assert late.until(lambda c: True, topic="factsheet")["serialNumber"] == "A-17"
        hall.kill()
        with Master(central.port, "bridges/hall-1") as watcher:
            heard = []
            watcher.client.on_message = lambda client, data, message: heard.append(
                json.loads(message.payload)
            )
            watcher._changed.acquire()
            watcher._changed.wait_for(lambda: 0 in heard, 5.0)
            watcher._changed.release()
            assert 0 in heard
