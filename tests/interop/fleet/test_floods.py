"""More than a vehicle can read, or a broker does: memory stays bounded, and all goes on afterwards."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.fleet_master import Master, errors, order_over, statuses
from tests.support.fleet_peers import ROOT
from tests.support.light_chassis import LightChassis, moving
from tests.support.mosquitto import Mosquitto, mosquitto
from woosh_pure.fleet import Broker, Store, Vehicle, VehicleConfig
from woosh_pure.fleet.inbox import MAX_MESSAGES
from woosh_pure.fleet.messages.parsing import MAX_MESSAGE_BYTES

pytestmark = [pytest.mark.interop, pytest.mark.slow]
pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
CONFIG = VehicleConfig(manufacturer="Woosh", serial="A-17", map_id="hall")
FLOOD = int(os.environ.get("WOOSH_FLOOD", "10000"))
"""Messages of nonsense; more by hand."""


@pytest.fixture
def hall(tmp_path: Path) -> Iterator[tuple[Mosquitto, Master, Vehicle]]:
    chassis = LightChassis(speed=5.0)
    with (
        mosquitto(tmp_path) as broker,
        Master(broker.port) as master,
        moving([chassis]),
        Vehicle(chassis, CONFIG, Broker(broker.url), Store(tmp_path, "Woosh", "A-17")) as ours,  # type: ignore[arg-type]
    ):
        master.until(lambda s: s["operatingMode"] == "AUTOMATIC" and s["agvPosition"]["positionInitialized"])
        yield broker, master, ours


def memory() -> float:
    """MB of this process."""
    text = Path("/proc/self/status").read_text()
    return int(text.partition("VmRSS:")[2].split()[0]) / 1024


def obeys(master: Master, name: str) -> None:
    """An order is driven, there and back."""
    master.send("order", order_over(name, "n1 n2 n1"))
    master.until(lambda s: s["orderId"] == name and s["lastNodeSequenceId"] == 4 and not s["nodeStates"])


@pytest.mark.promise("64 messages that stop, 32 of other instant actions, 8 orders, 8 invalid")
def test_a_flood_of_nonsense_is_survived(hall: Any) -> None:
    """What waits is bounded, the errors of a state are, too, and the next order is driven."""
    broker, master, ours = hall
    pieces = [b"", b"[]", b"{", b"\xff" * 300, b'{"headerId": 1, "orderId": "x"}', b'{"a":' * 2000]
    before, most = memory(), 0
    with Master(broker.port, "uagv/v2/Woosh/somebody") as vandal:
        vandal.prefix = master.prefix
        for number in range(FLOOD):
            vandal.send(("order", "instantActions")[number % 2], pieces[number % len(pieces)])
            most = max(most, ours._inbox.waiting_messages)
        deadline = time.monotonic() + 30.0
        while vandal.client.want_write():
            assert time.monotonic() < deadline
            time.sleep(0.05)
    assert most <= MAX_MESSAGES
    master.instant("now", "stateRequest")
    found = master.until(lambda s: statuses(s).get("now") == "FINISHED" or resent(master), 30.0)
    assert 0 < errors(found).count("validationError") <= 20
    obeys(master, "after")
    assert memory() - before < 100.0


@pytest.mark.promise("a flood takes no room from `cancelOrder` and `startPause`")
@pytest.mark.parametrize(("requests", "rate"), [(300, 0), (3000, 1000)])
def test_a_cancel_behind_a_flood_of_requests_is_obeyed(hall: Any, requests: int, rate: int) -> None:
    """300 at once and a cancel after them; 1000 a second and a cancel among them. Dropped messages are reported."""
    broker, master, ours = hall
    ours.chassis.speed = 0.03
    master.send("order", order_over("one", "n1 n2"))
    master.until(lambda s: s["driving"])
    numbers = [str(broker.port), master.prefix, str(requests), str(rate)]
    flood = [sys.executable, "-m", "tests.support.fleet_flood", *numbers]
    with subprocess.Popen(flood, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
        assert process.stdout is not None
        sent = float(process.stdout.readline())
        drive = ours.chassis.drive
        drive.wait(10.0)
        assert drive.done, f"it drives on {time.monotonic() - sent:.1f} s after the cancel"
        print(f"stopped {drive.ended_at - sent:.2f} s after the cancel, {ours.dropped} messages dropped")
    found = master.until(lambda s: statuses(s).get("stop") == "FINISHED" and not s["nodeStates"], 30.0)
    if ours.dropped:
        assert "messagesDropped" in errors(found)


def resent(master: Master) -> bool:
    """A request that came while too many waited was dropped: once more."""
    master.instant("now", "stateRequest")
    return False


@pytest.mark.promise("The connection limits the size of packets")
def test_a_message_that_is_too_long_is_not_delivered(hall: Any) -> None:
    """The broker drops it, by the size limit of the connection, which stays up, and the vehicle obeys."""
    _, master, _ = hall
    told = len(master.all("connection"))
    master.send("order", b"x" * (40 * MAX_MESSAGE_BYTES))
    obeys(master, "after")
    assert len(master.all("connection")) == told, "it was not lost meanwhile"
    assert not any("validationError" in errors(state) for state in master.all())


def test_a_retained_storm_is_not_obeyed(hall: Any) -> None:
    """Retained on both topics, with every return of the broker anew."""
    broker, master, ours = hall
    for n in range(2):
        broker.kill()
        broker.start()
        with Master(broker.port, "uagv/v2/Woosh/somebody") as other:
            other.prefix = master.prefix
            for topic in ("order", "instantActions"):
                other.send(topic, order_over(f"old{n}", "n1 n2"), retain=True)
            assert ours.wait_connected(5.0)
            master.until(lambda c: c["connectionState"] == "ONLINE", topic="connection")
    with master._changed:
        assert {s["orderId"] for s in master.all()} <= {"", *(f"old{n}" for n in range(2))}
