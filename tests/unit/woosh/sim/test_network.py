"""The simulated network: `restore` ends every wait for the end of an interruption."""

from __future__ import annotations

import threading
import time
from types import SimpleNamespace
from typing import Any

import pytest

from woosh_pure.sim.graph import RobotGoal
from woosh_pure.sim.network import Network


class Watched(Network):
    """Tells when somebody has asked for the time of an arrival."""

    def __init__(self) -> None:
        super().__init__()
        self.asked = threading.Event()

    def arrival(self) -> float:
        arrives = super().arrival()
        self.asked.set()
        return arrives


@pytest.mark.parametrize("end", [Network.restore, Network.close])
def test_a_request_on_its_way_arrives_when_the_link_is_restored_or_closed(end: Any) -> None:
    network = Watched()
    network.drop(300.0)
    request = threading.Thread(target=network.travel, daemon=True)
    request.start()
    assert network.asked.wait(20.0)
    end(network)
    request.join(20.0)
    assert not request.is_alive()


def test_a_cancel_on_its_way_arrives_when_the_link_is_restored() -> None:
    network = Network()
    firmware: Any = SimpleNamespace(message_class=str, convert=lambda message, _: message)
    sent: Any = SimpleNamespace(goal=None, cancel_requested=True)
    goal = RobotGoal(firmware, network, "woosh_msgs/StepControl", sent)
    network.drop(300.0)
    assert not goal.cancel_arrived()
    network.restore()
    assert goal.cancel_arrived()


def test_a_second_interruption_does_not_hold_up_what_was_on_its_way_through_a_delay() -> None:
    network = Network()
    network.delay = 0.01
    arrives = network.arrival()
    network.drop(300.0)
    assert network.earlier(arrives) == arrives
    assert arrives < time.monotonic() + 1.0
