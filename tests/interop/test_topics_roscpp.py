"""Topics between us and roscpp, both directions, on our master and on Debian's."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosproto.node import Node
from rosproto.node.graph.slave_client import NodeClient
from rosproto.node.incoming import udpros_link
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
        publisher.wait_for_connection(60)
        received.wait_for_connection(60)
        message = sample(type_name)
        assert wire(exchange(publisher, received, message)) == wire(message)
        assert wire(untyped.next(60)) == wire(message)


@pytest.mark.parametrize("type_name", ["std_msgs/String", "sensor_msgs/LaserScan"])
def test_datagrams_to_roscpp_and_back(
    any_master: str, roscpp_peer: Path, type_name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """UDPROS, which roscpp has too: a message in one datagram, and one in six; a quiet roscpp still has us."""
    monkeypatch.setattr(udpros_link, "QUIET_SECONDS", 0.5)
    asked = threading.Event()
    monkeypatch.setattr(NodeClient, "get_bus_info", noted(NodeClient.get_bus_info, asked))
    with (
        ros.start_program(roscpp_peer, any_master, "topic_echo", type_name, "unreliable"),
        Node("/ours", master_uri=any_master) as node,
    ):
        received = node.subscriber("/out", type_name, unreliable=True)
        publisher = node.publisher("/in", type_name)
        publisher.wait_for_connection(60)
        received.wait_for_connection(60)
        message = sample(type_name)
        for _ in range(300):  # numbers of messages begin again
            assert wire(exchange(publisher, received, message)) == wire(message)
        links = [link for link in node.stats().links if link.topic in ("/in", "/out")]
        assert {link.transport for link in links} == {"UDPROS"}
        asked.clear()
        assert asked.wait(20)
        assert wire(exchange(publisher, received, message)) == wire(message)
        assert [link.reconnects for link in received.stats()] == [0]


def noted(function: Callable[..., Any], called: threading.Event) -> Callable[..., Any]:
    """As the function; says that it was called."""

    def call(*args: Any, **options: Any) -> Any:
        try:
            return function(*args, **options)
        finally:
            called.set()

    return call


def test_a_restarted_roscpp_node_is_connected_again(any_master: str, roscpp_peer: Path) -> None:
    """Killed and started again, on other ports, under the same name: both directions come back."""
    with Node("/ours", master_uri=any_master) as node:
        received = node.subscriber("/out", "std_msgs/String", queue_size=1)
        publisher = node.publisher("/in", "std_msgs/String")
        for words in ("before", "after"):
            with ros.start_program(roscpp_peer, any_master, "topic_echo", "std_msgs/String") as program:
                publisher.wait_for_connection(60)
                received.wait_for_connection(60)
                while exchange(publisher, received, publisher.message_class(data=words)).data != words:
                    pass
                program.kill()
