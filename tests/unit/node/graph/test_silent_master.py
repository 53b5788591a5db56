"""A master that takes connections and says nothing: nobody waits longer than he asked, nothing stays in the graph."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from rosproto.errors import RosTimeout
from rosproto.master import Master
from rosproto.node import Node
from rosproto.node import context as context_module
from rosproto.node.graph.master_client import MasterClient
from rosproto.transport.uri import parse_uri
from tests.support.proxy import FaultProxy
from tests.support.victim import eventually


@pytest.fixture
def proxy(master: Master) -> Iterator[FaultProxy]:
    with FaultProxy("127.0.0.1", parse_uri(master.uri)[1]) as proxy:
        yield proxy


@pytest.fixture
def node(proxy: FaultProxy, monkeypatch: pytest.MonkeyPatch) -> Iterator[Node]:
    monkeypatch.setattr(context_module, "FAREWELL_SECONDS", 0.1)
    with Node("/n", master_uri=f"http://127.0.0.1:{proxy.port}", rosout=False) as node:
        yield node


def test_waiting_for_a_message_has_one_deadline(node: Node, proxy: FaultProxy) -> None:
    """Registering is a part of it; that of another topic, which waits ten seconds, is none."""
    proxy.stall()
    other = threading.Thread(target=node.subscriber, args=("/other", "std_msgs/Empty"))
    other.start()
    with pytest.raises(RosTimeout, match="registerSubscriber"):
        node.wait_for_message("/t", "std_msgs/Empty", timeout=0.3)
    proxy.resume()
    other.join(20)


def test_what_is_closed_meanwhile_leaves_the_graph_afterwards(
    node: Node, proxy: FaultProxy, master: Master
) -> None:
    """No program is told of a publisher that is gone; one opened again stays."""
    publishers = [node.publisher(topic, "std_msgs/Empty") for topic in ("/gone", "/again")]
    proxy.stall()
    for publisher in publishers:
        publisher.close()
    proxy.resume()
    kept = node.publisher("/again", "std_msgs/Empty")

    asked = MasterClient(master.uri, "/test")

    def published() -> set[str]:
        return set(asked.get_system_state().publishers)

    # What was asked to be taken back may reach the master late; it is registered again then.
    eventually(lambda: "/gone" not in published() and "/again" in published())
    kept.close()
    eventually(lambda: "/again" not in published())  # again in a tenth of a second, or by the master monitor
