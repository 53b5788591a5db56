"""Topics between us and roscpp, both directions, on our master and on Debian's."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.node import Node
from tests.interop.topic_samples import TYPES, exchange, sample, wire
from tests.support import ros


@pytest.mark.parametrize("type_name", TYPES)
def test_a_message_comes_back_from_roscpp_as_it_was(
    any_master: str, roscpp_peer: Path, type_name: str
) -> None:
    """Our publisher -> roscpp's subscriber -> roscpp's publisher -> our subscriber, byte for byte."""
    with (
        ros.start_program(roscpp_peer, any_master, "topic_echo", type_name),
        Node("/ours", master_uri=any_master) as node,
    ):
        received = node.subscriber("/out", type_name)
        untyped = node.subscriber("/out")
        publisher = node.publisher("/in", type_name)
        publisher.wait_for_connection(20)
        received.wait_for_connection(20)
        message = sample(type_name)
        assert wire(exchange(publisher, received, message)) == wire(message)
        assert wire(untyped.next(10)) == wire(message)


def test_a_restarted_roscpp_node_is_connected_again(any_master: str, roscpp_peer: Path) -> None:
    """Killed and started again, on other ports, under the same name: both directions come back."""
    with Node("/ours", master_uri=any_master) as node:
        received = node.subscriber("/out", "std_msgs/String", queue_size=1)
        publisher = node.publisher("/in", "std_msgs/String")
        for words in ("before", "after"):
            with ros.start_program(roscpp_peer, any_master, "topic_echo", "std_msgs/String") as program:
                publisher.wait_for_connection(20)
                received.wait_for_connection(20)
                while exchange(publisher, received, publisher.message_class(data=words)).data != words:
                    pass
                program.kill()
