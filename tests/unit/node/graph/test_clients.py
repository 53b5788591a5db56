"""The typed calls of a master and of another node, against real ones."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator

import pytest

from rosproto.errors import MasterError, RemoteProtocolError, RosTimeout
from rosproto.master import Master
from rosproto.node import MasterClient, Node, NodeClient
from rosproto.node.graph.master_client import LastGraph
from tests.support.victim import eventually


@pytest.fixture(scope="module")
def node() -> Iterator[Node]:
    with Master() as master, Node("/n", master_uri=master.uri, rosout=False, intraprocess=False) as node:
        yield node


def test_another_node_tells_what_it_is_and_does(node: Node) -> None:
    with (
        NodeClient(node.uri, "/test") as peer,
        node.publisher("/out", "std_msgs/String"),
        node.subscriber("/in", "std_msgs/UInt8"),
    ):
        assert peer.get_name() == "/n"
        assert peer.get_master_uri() == node.master_uri
        assert peer.get_publications() == [("/out", "std_msgs/String")]
        assert peer.get_subscriptions() == [("/in", "std_msgs/UInt8")]


def test_a_master_tells_a_node_publishers_and_parameters(node: Node) -> None:
    """As `rosproto.master` does; what comes from the master's address counts."""
    with NodeClient(node.uri, "/master") as peer, node.subscriber("/in", "std_msgs/UInt8") as subscriber:
        peer.publisher_update("/in", ["http://127.0.0.1:1/"])
        eventually(lambda: "http://127.0.0.1:1/" in subscriber.why_silent(), 5.0)
        peer.publisher_update("/in", [])
        eventually(lambda: subscriber.why_silent() == "no publisher is registered at the master", 5.0)
        changed = threading.Event()
        with node.params.subscribe("/followed", lambda key, value: changed.set()) as followed:
            peer.param_update("/followed", 7)
            assert changed.wait(5)
            assert followed.value == 7


def test_a_client_with_its_own_patience_shares_the_connection() -> None:
    """`within` is for calls that give no time-out; one that does has its way."""
    with socket.create_server(("127.0.0.1", 0)) as mute:
        uri = f"http://127.0.0.1:{mute.getsockname()[1]}/"
        with MasterClient(uri, "/test", timeout=30.0) as client:
            hasty = client.within(0.05)
            assert (hasty.uri, hasty.caller_id) == (client.uri, "/test")
            with pytest.raises(RosTimeout) as caught:
                hasty.get_pid()
            assert caught.value.seconds == 0.05
            with pytest.raises(RosTimeout) as caught:
                hasty.get_pid(timeout=0.1)
            assert caught.value.seconds == 0.1
        with NodeClient(uri, "/test", timeout=30.0) as peer, pytest.raises(RosTimeout):
            peer.within(0.05).get_name()


@pytest.mark.parametrize("multicall", [True, False], ids=["in one request", "one by one"])
def test_several_calls_give_a_value_or_an_error_each(
    node: Node, monkeypatch: pytest.MonkeyPatch, multicall: bool
) -> None:
    """A master without system.multicall is asked one by one, with the same answers."""

    def refused(*args: object, **options: object) -> list[object]:
        raise RemoteProtocolError("no such method: system.multicall")

    with MasterClient(node.master_uri, "/test") as client, node.publisher("/out", "std_msgs/String"):
        if not multicall:
            monkeypatch.setattr(client, "multicall", refused)
        uri, missing = client.batch([("lookupNode", ("/n",)), ("lookupNode", ("/nobody",))])
        assert uri == node.uri
        assert isinstance(missing, MasterError)
        assert missing.code == -1


def test_a_graph_that_has_not_changed_is_not_decoded_again() -> None:
    """It is read every few seconds, and a large one takes long."""
    last = LastGraph()
    with Master() as master, MasterClient(master.uri, "/n") as client:
        client.register_publisher("/a", "std_msgs/String", "http://127.0.0.1:1/")
        first = client.get_system_state(last=last)
        assert client.get_system_state(last=last) is first
        client.register_publisher("/b", "std_msgs/String", "http://127.0.0.1:1/")
        changed = client.get_system_state(last=last)
        assert changed == client.get_system_state()
        assert sorted(changed.publishers) == ["/a", "/b"]
