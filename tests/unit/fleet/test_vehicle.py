"""The glue of a vehicle, without a network."""

from __future__ import annotations

import pytest

from woosh_pure import Chassis
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.mqtt.broker import Broker

pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")


def test_a_flood_of_messages_is_bounded() -> None:
    """Beyond a hundred that wait they are dropped, and counted."""
    from woosh_pure.fleet.inbox import MOST_MESSAGES
    from woosh_pure.fleet.vehicle import Vehicle

    config = VehicleConfig(manufacturer="W", serial="1")
    vehicle = Vehicle(Chassis("127.0.0.1:1"), config, Broker("mqtt://127.0.0.1:1"))
    for _ in range(3 * MOST_MESSAGES):
        vehicle._on_message("order", b"{}")
    assert vehicle._inbox.waiting_messages == MOST_MESSAGES
    assert vehicle.dropped == 2 * MOST_MESSAGES
