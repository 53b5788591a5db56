"""Who exchanges messages without a socket: all nodes of a process, or those that share a table of their own."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rosproto import Master, Node
from rosproto.node.incoming.local_nodes import LocalNodes


@pytest.fixture
def master() -> Iterator[Master]:
    with Master(host="127.0.0.1", port=0) as master:
        yield master


def transports(subscriber_node: Node) -> list[str]:
    return [link.transport for link in subscriber_node.stats().links if link.direction == "in"]


def test_nodes_with_a_table_of_their_own_are_local_to_each_other_and_to_nobody_else(master: Master) -> None:
    ours = LocalNodes()
    options = {"master_uri": master.uri, "host": "127.0.0.1", "rosout": False}
    with (
        Node("/a", intraprocess=ours, **options) as a,
        Node("/b", intraprocess=ours, **options) as b,
        Node("/stranger", **options) as stranger,
        a.publisher("/t", "std_msgs/String", latch=True) as publisher,
        b.subscriber("/t", "std_msgs/String") as beside,
        stranger.subscriber("/t", "std_msgs/String") as outside,
        stranger.publisher("/u", "std_msgs/String", latch=True) as theirs,
        b.subscriber("/u", "std_msgs/String") as from_outside,
    ):
        publisher.publish(data="x")
        theirs.publish(data="y")
        assert beside.next(timeout=5).data == outside.next(timeout=5).data == "x"
        assert from_outside.next(timeout=5).data == "y"
        assert sorted(transports(b)) == ["INTRAPROCESS", "TCPROS"]
        assert transports(stranger) == ["TCPROS"]


def test_a_simulation_tells_of_the_links_that_it_simulates(master: Master) -> None:
    ours = LocalNodes(told_as="TCPROS")
    options = {"master_uri": master.uri, "host": "127.0.0.1", "rosout": False, "intraprocess": ours}
    with (
        Node("/a", **options) as a,
        Node("/b", **options) as b,
        a.publisher("/t", "std_msgs/String", latch=True) as publisher,
        b.subscriber("/t", "std_msgs/String") as subscriber,
    ):
        publisher.publish(data="x")
        assert subscriber.next(timeout=5).data == "x"
        assert [link.transport for node in (a, b) for link in node.stats().links] == ["TCPROS", "TCPROS"]


def test_a_closed_node_is_in_no_table(master: Master) -> None:
    ours = LocalNodes()
    with Node("/a", master_uri=master.uri, host="127.0.0.1", rosout=False, intraprocess=ours) as a:
        uri = a.uri
        assert ours.find(uri) is not None
    assert ours.find(uri) is None
    assert ours.find("no URI") is None
