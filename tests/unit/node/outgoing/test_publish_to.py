"""A message for one subscriber only."""

from __future__ import annotations

from rosproto.codec import encode, message_class
from rosproto.node import Node

String = message_class("std_msgs/String")


def test_a_message_goes_to_the_subscriber_that_is_named(nodes: tuple[Node, Node]) -> None:
    """The others get what is published, in order; who is not there is told of."""
    a, b = nodes
    publisher = a.publisher("/one", String)
    to_b, to_a = b.subscriber("/one", String), a.subscriber("/one", String)
    publisher.wait_for_connection(20, count=2)
    assert publisher.publish_to(b.name, encode(String(data="for b")))
    publisher.publish(data="for all")
    assert [to_b.next(20).data for _ in range(2)] == ["for b", "for all"]
    assert to_a.next(20).data == "for all"
    assert not publisher.publish_to("/nobody", encode(String(data="for nobody")))
