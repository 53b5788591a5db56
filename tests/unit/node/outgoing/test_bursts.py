"""When a publisher's messages are joined, and when each goes out at once."""

from __future__ import annotations

import pytest

from rosproto.node import Node
from rosproto.node.outgoing import publication as module
from rosproto.node.outgoing.publication import BURST_GAP, BURST_LENGTH


class Link:
    """A subscriber that notes how it was sent to."""

    def __init__(self) -> None:
        self.how: list[str] = []

    def send(self, frame: bytes) -> None:
        self.how.append("at once")

    def send_soon(self, frame: bytes, now: float) -> bool:
        self.how.append("joined")
        return False


def publish_every(seconds: float, nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """How messages go out that the program publishes so long after each other."""
    now, link = [100.0], Link()
    with nodes[0].publisher("/burst", "std_msgs/String") as publisher, monkeypatch.context() as patch:
        patch.setattr(module, "perf_counter", lambda: now[0])
        patch.setattr(publisher._publication, "links", (link,))
        for _ in range(10 * BURST_LENGTH):
            now[0] += seconds
            publisher.publish(data="x")
    return link.how


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
