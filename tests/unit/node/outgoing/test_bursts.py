"""When a publisher's messages are joined, and when each goes out at once."""

from __future__ import annotations

import pytest

from rosproto.node import Node
from rosproto.node.outgoing import publication as module
from rosproto.node.outgoing.publication import BURST_GAP, BURST_LENGTH
from rosproto.node.outgoing.subscriber_link import SubscriberLink

pytestmark = pytest.mark.parametrize("nodes", [False], indirect=True, ids=["tcp"])


def publish_every(seconds: float, nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """How messages go out that the program publishes so long after each other."""
    now, how = [100.0], []

    def send(link: SubscriberLink, frame: bytes) -> None:
        how.append("at once")

    def send_soon(link: SubscriberLink, frame: bytes, now: float) -> bool:
        how.append("joined")
        return False

    with (
        nodes[0].publisher("/burst", "std_msgs/String") as publisher,
        nodes[1].subscriber("/burst", "std_msgs/String"),
        monkeypatch.context() as patch,
    ):
        publisher.wait_for_connection(20)
        patch.setattr(module, "perf_counter", lambda: now[0])
        patch.setattr(SubscriberLink, "send", send)
        patch.setattr(SubscriberLink, "send_soon", send_soon)
        for _ in range(10 * BURST_LENGTH):
            now[0] += seconds
            publisher.publish(data="x")
    return how


def test_a_loop_that_does_little_else_than_publish_is_a_burst(
    nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a few messages; the others are joined."""
    how = publish_every(BURST_GAP / 2, nodes, monkeypatch)
    assert how[:BURST_LENGTH] == ["at once"] * BURST_LENGTH
    assert set(how[BURST_LENGTH + 1 :]) == {"joined"}


def test_pings_whose_answers_come_within_microseconds_are_none(
    nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two processes on one processor answer each other in 9 us, 5 after `publish`: a batch would hold them up for 1 ms."""
    assert set(publish_every(5e-6, nodes, monkeypatch)) == {"at once"}
