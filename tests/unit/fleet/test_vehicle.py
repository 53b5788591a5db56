"""`Vehicle` without a network: its inbox, and when its thread is woken."""

from __future__ import annotations

import pytest

from tests.support.fleet import order_json
from woosh_pure import Chassis
from woosh_pure.fleet.config import Broker, VehicleConfig
from woosh_pure.fleet.inbox import Inbox
from woosh_pure.fleet.messages.parsing import read_order
from woosh_pure.fleet.order.events import ModeChanged, PositionMeasured
from woosh_pure.fleet.order.vehicle_limits import AgvPosition

pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")


@pytest.mark.promise("64 messages that stop, 32 of other instant actions, 8 orders, 8 invalid")
def test_a_flood_of_messages_is_bounded() -> None:
    """Messages beyond the capacity of their kind are dropped and counted."""
    from woosh_pure.fleet.inbox import CAPACITY, MessageKind
    from woosh_pure.fleet.vehicle import Vehicle

    config = VehicleConfig(manufacturer="W", serial="1")
    vehicle = Vehicle(Chassis("127.0.0.1:1"), config, Broker("mqtt://127.0.0.1:1"))
    for _ in range(100):
        vehicle._on_message("order", b"{}")
    assert vehicle._inbox.waiting_messages == CAPACITY[MessageKind.MALFORMED]
    assert vehicle.dropped == 100 - CAPACITY[MessageKind.MALFORMED]


def test_a_pose_that_changes_nothing_wakes_nobody() -> None:
    """Ten poses a second come of each robot; the vehicle's thread sees those at the node, and those of a change."""
    from woosh_pure.fleet.vehicle import Vehicle

    config = VehicleConfig(manufacturer="W", serial="1")
    vehicle = Vehicle(Chassis("127.0.0.1:1"), config, Broker("mqtt://127.0.0.1:1"))
    vehicle._inbox.due["now"] = 0.0  # a look into it does not wait
    order, facts = vehicle._order, vehicle.facts
    facts.position, facts.located = AgvPosition(0.0, 0.0, 0.0, "map"), True
    for event in (ModeChanged("AUTOMATIC"), PositionMeasured(facts.position)):
        list(order.apply(event))
    data = order_json(nodes="ab", deviation=0.5)
    for node in data["nodes"]:
        node["nodePosition"]["mapId"] = "map"
    list(order.apply(read_order(data)))
    assert order.state.driving
    woken: list[set[str]] = []
    for x in (0.5, 1.0, 1.4, 1.6, 2.0):
        facts.position = AgvPosition(x, 0.0, 0.0, "map")
        vehicle._on_motion()
        woken.append(flags(vehicle._inbox))
    assert woken == [set(), set(), set(), {"motion"}, {"motion"}]
    facts.located = False
    vehicle._on_motion()
    assert flags(vehicle._inbox) == {"motion"}


def flags(inbox: Inbox) -> set[str]:
    left = inbox.wait()
    assert left is not None
    return left.flags
