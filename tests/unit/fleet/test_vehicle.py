"""`Vehicle` without a network: its inbox, and when its thread is woken."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tests.support.fleet import order_json
from woosh_pure import Chassis
from woosh_pure.fleet import vehicle as module
from woosh_pure.fleet.config import Broker, VehicleConfig
from woosh_pure.fleet.inbox import CAPACITY, Inbox, MessageKind
from woosh_pure.fleet.messages.parsing import read_order
from woosh_pure.fleet.order.events import ModeChanged, PositionMeasured
from woosh_pure.fleet.order.vehicle_limits import AgvPosition

pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")


class Parts:
    """A vehicle, and of its parts those that a test plays: each by its class, with what the vehicle gave to it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.made: dict[str, tuple[Any, tuple[Any, ...]]] = {}
        for name in ("Inbox", "PersistentOrder", "BrokerConnection", "ChassisMonitor"):
            monkeypatch.setattr(module, name, self._maker(name, getattr(module, name)))
        config = VehicleConfig(manufacturer="W", serial="1")
        self.vehicle = module.Vehicle(Chassis("127.0.0.1:1"), config, Broker("mqtt://127.0.0.1:1"))
        self.inbox: Inbox = self.made["Inbox"][0]

    def _maker(self, name: str, kind: Callable[..., Any]) -> Callable[..., Any]:
        def make(*given: Any) -> Any:
            self.made[name] = kind(*given), given
            return self.made[name][0]

        return make


@pytest.fixture
def parts(monkeypatch: pytest.MonkeyPatch) -> Parts:
    return Parts(monkeypatch)


@pytest.mark.promise("64 messages that stop, 32 of other instant actions, 8 orders, 8 invalid")
def test_a_flood_of_messages_is_bounded(parts: Parts) -> None:
    """Messages beyond the capacity of their kind are dropped and counted."""
    _, (*_, arrived, _) = parts.made["BrokerConnection"]
    for _ in range(100):
        arrived("order", b"{}")
    assert parts.inbox.waiting_messages == CAPACITY[MessageKind.MALFORMED]
    assert parts.vehicle.dropped == 100 - CAPACITY[MessageKind.MALFORMED]


def test_a_pose_that_changes_nothing_wakes_nobody(parts: Parts) -> None:
    """Ten poses a second come of each robot; the vehicle's thread sees those of a change, and those at a node that
    it passes without a stop. At the last node it waits for the end of the drive."""
    _, (_, facts, moved, *_) = parts.made["ChassisMonitor"]
    order = parts.made["PersistentOrder"][0]
    parts.inbox.due["now"] = 0.0  # a look into it does not wait
    facts.position, facts.located = AgvPosition(0.0, 0.0, 0.0, "map"), True
    for event in (ModeChanged("AUTOMATIC"), PositionMeasured(facts.position)):
        list(order.apply(event))
    data = order_json(nodes="abc", deviation=0.5)
    for node in data["nodes"]:
        node["nodePosition"]["mapId"] = "map"
    list(order.apply(read_order(data)))
    assert order.state.driving
    woken: list[set[str]] = []
    for x in (0.5, 1.0, 1.4, 1.6, 2.0):
        facts.position = AgvPosition(x, 0.0, 0.0, "map")
        moved()
        woken.append(flags(parts.inbox))
    assert woken == [set(), set(), set(), {"motion"}, {"motion"}]
    list(order.apply(PositionMeasured(facts.position)))
    facts.position = AgvPosition(4.0, 0.0, 0.0, "map")
    moved()
    assert flags(parts.inbox) == set()
    facts.located = False
    moved()
    assert flags(parts.inbox) == {"motion"}


def flags(inbox: Inbox) -> set[str]:
    left = inbox.wait()
    assert left is not None
    return left.flags
