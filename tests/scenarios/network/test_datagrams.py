"""Topics in datagrams over a network that loses packets and goes away: messages are missing, and none is late."""

from __future__ import annotations

import pytest

from tests.scenarios.network.conftest import FRESH, Network, soon, wait
from tests.support.load import crowd

pytestmark = pytest.mark.slow


def test_loss_and_silence_cost_messages_not_time(connected: Network) -> None:
    """A fifth lost, then all of four seconds: what comes is fresh and in order, and the rest is counted."""
    robot, laptop, air = connected
    robot.python.do("quick = Ticker(node, '/quick', 50)")
    laptop.python.do("quick = Heard(node, '/quick', unreliable=True)")
    laptop.python.eventually("quick.messages")
    air.there.loss = 0.2
    began = wait(4.0)
    lossy = laptop.python.ask("quick.since(0.0)")
    air.silence()
    wait(4.0)
    air.clear()
    gone = wait(0.0)
    laptop.python.eventually(f"quick.first_sent_after({gone!r})")
    assert laptop.python.ask(f"quick.first_sent_after({gone!r})") - gone < soon(1.0)
    wait(1.0)
    heard = laptop.python.ask("quick.since(0.0)")
    numbers = [number for _, _, number in heard]
    assert numbers == sorted(set(numbers))
    assert max(got - sent for got, sent, _ in heard) < FRESH * crowd()
    present = [number for got, _, number in lossy if got < began]
    missing = 1 - len(present) / (present[-1] - present[0] + 1)
    assert 0.05 < missing < 0.5
    (link,) = laptop.python.ask("[(s.transport, s.dropped) for s in quick.subscriber.stats()]")
    assert link[0] == "UDPROS"
    assert link[1] >= missing * len(present)
