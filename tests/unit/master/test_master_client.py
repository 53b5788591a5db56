"""Typed calls of masters and nodes: every method once, and peers with unusual replies."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from rosproto.errors import ConnectionLost, MasterError, RemoteProtocolError
from rosproto.master import Master
from rosproto.node.graph.master_client import MasterClient, SystemState
from rosproto.node.graph.slave_client import BusConnection, NodeClient
from rosproto.transport import XmlRpcServer

URI = "http://127.0.0.1:1/"


class Peer:
    """Answers every call with `reply`; remembers the last one."""

    def __init__(self) -> None:
        self.reply: object = [1, "", 0]
        self.last: tuple[str, list[object]] = ("", [])
        self.server = XmlRpcServer("127.0.0.1", 0, self._dispatch)

    def _dispatch(self, method: str, params: list[object], peer: object) -> object:
        self.last = (method, params)
        return self.reply


@pytest.fixture
def peer() -> Iterator[Peer]:
    made = Peer()
    yield made
    made.server.close()


def test_every_master_method_against_a_real_master() -> None:
    """The whole Master and Parameter Server API, typed."""
    with Master() as master, MasterClient(master.uri, "/ns/n") as me:
        assert me.register_publisher("/t", "a/B", URI) == []
        assert me.register_subscriber("/t", "*", URI) == [URI]
        me.register_service("/s", "rosrpc://127.0.0.1:2", URI)
        assert me.lookup_node("/ns/n") == URI
        assert me.lookup_service("/s") == "rosrpc://127.0.0.1:2"
        assert me.get_published_topics() == me.get_topic_types() == {"/t": "a/B"}
        assert me.get_published_topics("/elsewhere") == {}
        state = me.get_system_state()
        assert state == SystemState({"/t": ["/ns/n"]}, {"/t": ["/ns/n"]}, {"/s": ["/ns/n"]})
        assert state.nodes == ["/ns/n"]
        assert me.get_uri() == master.uri
        assert me.get_pid() == os.getpid()
        assert me.subscribe_param("/ns/k", URI) == {}
        me.set_param("/ns/k", {"x": 1})
        assert me.get_param("/ns/k/x") == 1
        assert me.has_param("/ns/k")
        assert not me.has_param("/ns/q")
        assert me.search_param("k") == "/ns/k"
        assert "/ns/k/x" in me.get_param_names()
        me.delete_param("/ns/k")
        me.unsubscribe_param("/ns/k", URI)
        assert me.unregister_service("/s", "rosrpc://127.0.0.1:2") == 1
        assert me.unregister_subscriber("/t", URI) == 1
        assert me.unregister_publisher("/t", URI) == 1
        assert me.unregister_publisher("/t", URI) == 0


def test_no_is_a_master_error_with_code_text_and_uri() -> None:
    """What is not there, and what was asked wrongly."""
    with Master() as master, MasterClient(master.uri, "/n") as me:
        for call in (me.get_param, me.delete_param, me.search_param, me.lookup_node, me.lookup_service):
            with pytest.raises(MasterError) as refused:
                call("nothing")
            assert refused.value.code == -1
            assert refused.value.uri == master.uri
            assert refused.value.text


def test_a_master_that_is_away_is_a_lost_connection() -> None:
    """Named by its URI."""
    with Master() as master:
        pass
    with MasterClient(master.uri, "/n") as me, pytest.raises(ConnectionLost, match=str(master.port)):
        me.get_pid()


@pytest.mark.parametrize(
    ("call", "method", "params", "reply", "value"),
    [
        ("get_bus_stats()", "getBusStats", [], [[], [], []], [[], [], []]),
        ("get_master_uri()", "getMasterUri", [], URI, URI),
        ("get_pid()", "getPid", [], 5, 5),
        ("get_name()", "getName", [], "/n", "/n"),
        ("get_subscriptions()", "getSubscriptions", [], [["/t", "a/B"]], [("/t", "a/B")]),
        ("get_publications()", "getPublications", [], [], []),
        ("request_topic('/t')", "requestTopic", ["/t", [["TCPROS"]]], ["TCPROS", "h", 5], ["TCPROS", "h", 5]),
        ("request_topic('/t')", "requestTopic", ["/t", [["TCPROS"]]], 0, []),
        ("shutdown('why')", "shutdown", ["why"], 0, None),
        ("param_update('/k/', {'a': 1})", "paramUpdate", ["/k/", {"a": 1}], 0, None),
        ("publisher_update('/t', ('u',))", "publisherUpdate", ["/t", ["u"]], 0, None),
        (
            "get_bus_info()",
            "getBusInfo",
            [],
            [[1, "/p", "i", "TCPROS", "/t", True, "words"], [2, "/q", "o", "TCPROS", "/t"]],
            [
                BusConnection(1, "/p", "i", "TCPROS", "/t", True, "words"),
                BusConnection(2, "/q", "o", "TCPROS", "/t", True, ""),
            ],
        ),
    ],
)
def test_every_slave_method(
    peer: Peer, call: str, method: str, params: list[object], reply: object, value: object
) -> None:
    """What is sent, with our name first, and what comes back."""
    peer.reply = [1, "", reply]
    with NodeClient(peer.server.uri, "/me") as node:
        assert eval(f"node.{call}", {"node": node}) == value
    assert peer.last == (method, ["/me", *params])


@pytest.mark.promise("Replies come misshapen")
def test_roscpp_gives_its_statistics_without_code_and_text(peer: Peer) -> None:
    """Its TopicManager overwrites the reply with the value."""
    peer.reply = [[["/t", [[0, 624, 624, 12, 0]]]], [], []]
    with NodeClient(peer.server.uri, "/me") as node:
        assert node.get_bus_stats()[0] == [["/t", [[0, 624, 624, 12, 0]]]]


@pytest.mark.parametrize("reply", ["text", 5, [], ["x", "", 0], {}, True])
def test_a_reply_that_is_no_triple_is_the_peers_fault(peer: Peer, reply: object) -> None:
    """RemoteProtocolError, and it says what came."""
    peer.reply = reply
    with MasterClient(peer.server.uri, "/me") as master, pytest.raises(RemoteProtocolError, match="getPid"):
        master.get_pid()


@pytest.mark.parametrize(
    ("call", "value"),
    [
        ("register_publisher('/t', 'a/B', 'u')", [1, 2]),
        ("register_subscriber('/t', 'a/B', 'u')", "text"),
        ("lookup_node('/n')", 5),
        ("get_published_topics()", [["/t"]]),
        ("get_topic_types()", [[1, 2]]),
        ("get_system_state()", [[], []]),
        ("get_system_state()", [[["/t", [5]]], [], []]),
        ("get_system_state()", [[["/t"]], [], []]),
        ("has_param('/k')", "yes"),
        ("has_param('/k')", 5),
        ("get_pid()", "5"),
        ("get_param_names()", [["a"]]),
    ],
)
def test_a_value_of_the_wrong_type_is_the_peers_fault(peer: Peer, call: str, value: object) -> None:
    """Nothing of another type gets to the caller."""
    peer.reply = [1, "", value]
    with MasterClient(peer.server.uri, "/me") as master, pytest.raises(RemoteProtocolError, match="expected"):
        eval(f"master.{call}", {"master": master})


def test_what_peers_send_for_nothing_is_understood(peer: Peer) -> None:
    """0, "" and missing values where a list belongs; 0 and 1 for a boolean."""
    with MasterClient(peer.server.uri, "/me") as master:
        for nothing in ([1, "", 0], [1, "", ""], [1, "", []], [1]):
            peer.reply = nothing
            assert master.register_subscriber("/t", "*", "u") == []
        peer.reply = [1, "", 1]
        assert master.has_param("/k") is True
