"""Calls of a master in the same process: the same replies as over its port, without a connection."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rosproto import Master, Node
from rosproto.errors import ConnectionLost, MasterError
from rosproto.master.local_client import LocalClient
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.incoming.local_nodes import LocalNodes
from tests.support.slaves import RecordingNode

OTHER = "http://127.0.0.1:9/"


@pytest.fixture
def master() -> Iterator[Master]:
    with Master() as master:
        yield master


@pytest.fixture
def local(master: Master) -> Iterator[MasterClient]:
    carrier = LocalClient(master, limits=None, timeout=5.0, hosts=None)
    with MasterClient(master.uri, "/local", client=carrier) as client:
        yield client


def test_its_answers_are_those_of_the_port(master: Master, local: MasterClient) -> None:
    """One call after another, each asked both ways; what changes the graph is asked with a name for each way."""
    answers = []
    with MasterClient(master.uri, "/local") as over_port:
        for client in (local, over_port):
            answers.append(
                [
                    client.batch(
                        [
                            ("registerPublisher", ("/t", "std_msgs/String", OTHER)),
                            ("registerSubscriber", ("/t", "*", OTHER)),
                            ("registerPublisher", ("/t", "std_msgs/String", "no uri")),
                            ("registerService", ("/s", "rosrpc://127.0.0.1:9", OTHER)),
                        ]
                    ),
                    client.get_pid(),
                    client.lookup_service("/s"),
                    client.get_param("/rosdistro"),
                    client.get_system_state(),
                    client.unregister_publisher("/t", OTHER),
                    client.unregister_publisher("/t", OTHER),
                    client.unregister_subscriber("/t", OTHER),
                    client.unregister_service("/s", "rosrpc://127.0.0.1:9"),
                ]
            )
    assert str(answers[0]) == str(answers[1])
    assert isinstance(answers[0][0][2], MasterError)  # type: ignore[index]


def test_a_call_opens_no_connection_and_a_rare_one_takes_the_port(
    master: Master, local: MasterClient
) -> None:
    local.register_publisher("/t", "std_msgs/String", OTHER)
    local.batch([("getPid", ()), ("getParam", ("/unset",))])
    assert master.stats()["connections"] == 0
    local.set_param("/x", {"y": [1, 2]})
    assert master.stats()["connections"] == 1
    with pytest.raises(MasterError, match='method "nonsense" is not supported'):
        local.call("nonsense")
    mixed = local.multicall([("setParam", ("/z", 1)), ("getParam", ("/z",))])
    assert mixed == [0, 1]


def test_what_it_returned_is_the_callers_own(local: MasterClient) -> None:
    local.set_param("/x", {"y": [1, 2]})
    value = local.get_param("/x")
    assert value == {"y": [1, 2]}
    value["y"].append(3)
    assert local.get_param("/x") == {"y": [1, 2]}


def test_others_are_told(master: Master, local: MasterClient) -> None:
    with RecordingNode() as node, MasterClient(master.uri, "/s") as stranger:
        assert stranger.register_subscriber("/t", "*", node.uri) == []
        assert local.register_publisher("/t", "std_msgs/String", OTHER) == [node.uri]
        assert master.flush(5.0)
        assert ("publisherUpdate", ["/t", [OTHER]]) in node.calls


def test_a_closed_master_and_a_closed_client_fail_as_over_the_network(
    master: Master, local: MasterClient
) -> None:
    other = MasterClient(
        master.uri, "/other", client=LocalClient(master, limits=None, timeout=5.0, hosts=None)
    )
    other.close()
    with pytest.raises(ConnectionLost, match="closed"):
        other.get_pid()
    assert local.get_pid() > 0
    master.close()
    with pytest.raises(ConnectionLost):
        local.get_pid()


def test_nodes_take_the_short_way_only_to_the_master_they_were_given(master: Master) -> None:
    ours = LocalNodes(master=master)
    options = {"host": "127.0.0.1", "intraprocess": ours}
    with Master() as another:
        with (
            Node("/a", master_uri=master.uri, **options) as a,  # type: ignore[arg-type]
            a.publisher("/t", "std_msgs/String"),
            Node("/b", master_uri=another.uri, **options),  # type: ignore[arg-type]
            Node("/c", master_uri=another.uri, host="127.0.0.1"),
        ):
            assert master.stats()["connections"] == 0
            assert another.stats()["connections"] >= 2
            with MasterClient(master.uri, "/look") as look:
                assert look.get_system_state().publishers["/t"] == ["/a"]
        with MasterClient(master.uri, "/look") as look:
            assert look.get_system_state() == ({}, {}, {})  # and they left it
