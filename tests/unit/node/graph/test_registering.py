"""Many registrations in one request: what stands, what is closed, and what a master without multicall gets."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rosproto import ActionServer, Master, Node
from rosproto.errors import (
    ConnectionLost,
    LocalProtocolError,
    MasterError,
    RegistrationsRefused,
    RemoteProtocolError,
)
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.slave_client import NodeClient
from rosproto.node.incoming.local_nodes import LocalNodes
from rosproto.transport import XmlRpcClient
from tests.support.victim import eventually


@pytest.fixture
def master() -> Iterator[Master]:
    with Master(host="127.0.0.1", port=0) as master:
        yield master


class Asked(LocalNodes):
    """Carries a node's calls to its master. It notes their methods, and answers some in the master's place."""

    def __init__(self) -> None:
        super().__init__()
        self.methods: list[str] = []
        self.refuse: dict[str, str] = {}
        self.instead: Exception | None = None
        self._carrier: Carrier | None = None

    def calls_to(self, uri: str, **options: Any) -> XmlRpcClient | None:
        """The node's own client is watched, not the one of its farewell."""
        if self._carrier is not None:
            return None
        self._carrier = Carrier(uri, **options)
        self._carrier.asked = self
        return self._carrier

    def answer(self, call: Callable[..., Any], method: str, *params: Any, **options: Any) -> Any:
        look = method == "system.multicall" and params[0][0]["methodName"] == "getPid"
        if method != "system.multicall" or look:
            self.methods.append("look" if look else method)
            return call(method, *params, **options)
        if self.instead is not None:
            raise self.instead
        names = [each["params"][1] for each in params[0]]
        self.methods.append(f"system.multicall {len(names)}")
        passed = [each for each, name in zip(params[0], names, strict=True) if name not in self.refuse]
        answers = iter(call(method, passed, **options) if passed else ())
        return [[[-1, self.refuse[name], 0]] if name in self.refuse else next(answers) for name in names]


class Carrier(XmlRpcClient):
    asked: Asked

    def call(self, method: str, *params: Any, **options: Any) -> Any:
        return self.asked.answer(super().call, method, *params, **options)


@pytest.fixture
def asked() -> Asked:
    return Asked()


@pytest.fixture
def node(master: Master, asked: Asked) -> Iterator[Node]:
    with Node("/n", master_uri=master.uri, host="127.0.0.1", rosout=False, intraprocess=asked) as node:
        yield node


def told_again(node: Node, asked: Asked) -> list[str]:
    """What a node tells its master when it has compared the graph with what it has registered."""
    asked.methods.clear()
    node.watch_master(period=0.01, full_check_every=1)
    node.check_master_now()
    eventually(lambda: asked.methods.count("look") >= 3)
    node.watch_master(period=60.0, full_check_every=5)
    return [each for each in asked.methods if each not in ("look", "getSystemState")]


def registered(master: Master, name: str) -> bool:
    with MasterClient(master.uri, "/tool") as client:
        return any(name in table for table in client.get_system_state())


def opened(node: Node) -> tuple[Any, Any, Any]:
    return (
        node.publisher("/a", "std_msgs/String"),
        node.subscriber("/b", "std_msgs/String"),
        node.service_server("/c", "std_srvs/Empty", lambda request: None),
    )


def test_a_block_registers_with_one_request_at_its_end(master: Master, node: Node, asked: Asked) -> None:
    with node.batch():
        opened(node)
        assert not any(registered(master, name) for name in ("/a", "/b", "/c"))
    assert all(registered(master, name) for name in ("/a", "/b", "/c"))
    assert [m for m in asked.methods if m.startswith(("register", "system"))] == ["system.multicall 3"]


def test_what_was_published_before_and_comes_after_is_found(master: Master, node: Node) -> None:
    """The answer to each registration counts as it does alone, and so do the master's updates."""
    with Node("/other", master_uri=master.uri, host="127.0.0.1", intraprocess=False) as other:
        early = other.publisher("/early", "std_msgs/String", latch=True)
        early.publish(data="1")
        with node.batch():
            first = node.subscriber("/early", "std_msgs/String")
            second = node.subscriber("/late", "std_msgs/String")
        assert first.next(timeout=5).data == "1"
        with other.batch():
            late = other.publisher("/late", "std_msgs/String", latch=True)
            late.publish(data="2")
        assert second.next(timeout=5).data == "2"


def test_a_block_within_a_block_is_part_of_it(master: Master, node: Node, asked: Asked) -> None:
    with node.batch():
        with node.batch():
            node.publisher("/a", "std_msgs/String")
        assert not registered(master, "/a")
        node.publisher("/b", "std_msgs/String")
    assert "system.multicall 2" in asked.methods


def test_another_thread_registers_at_once(master: Master, node: Node) -> None:
    """It has not asked to wait, and may depend on it."""
    with node.batch():
        thread = threading.Thread(target=node.publisher, args=("/other", "std_msgs/String"))
        thread.start()
        thread.join(5)
        assert registered(master, "/other")


def test_what_is_closed_within_the_block_is_never_registered(
    master: Master, node: Node, asked: Asked
) -> None:
    with node.batch():
        publisher, subscriber, server = opened(node)
        publisher.close()
        subscriber.close()
        server.close()
        node.publisher("/a", "std_msgs/String")
    assert asked.methods.count("registerPublisher") == 1
    assert "unregisterPublisher" not in asked.methods
    assert registered(master, "/a")
    assert not registered(master, "/b")


def test_a_block_that_raises_closes_what_it_opened(master: Master, node: Node) -> None:
    things: list[Any] = []

    def broken() -> None:
        things.extend(opened(node))
        raise KeyError

    with pytest.raises(KeyError), node.batch():
        broken()
    assert things[0].closed
    assert things[1].closed
    assert not any(registered(master, name) for name in ("/a", "/b", "/c"))
    opened(node)  # nothing of it is in the way
    assert all(registered(master, name) for name in ("/a", "/b", "/c"))


@pytest.mark.parametrize("refused", ["/work/status", "all of it"])
def test_an_action_server_whose_topics_are_closed_is_closed_and_logs_no_error(
    node: Node, asked: Asked, caplog: pytest.LogCaptureFixture, refused: str
) -> None:
    """Ctrl-C at the start of a program ends its block; a status that nobody can hear is no reason for a message."""
    asked.refuse[refused] = "no"
    with pytest.raises((KeyboardInterrupt, MasterError)), node.batch():  # noqa: PT012
        server = ActionServer(node, "/work", "actionlib/TestAction", lambda goal: None)
        if refused == "all of it":
            raise KeyboardInterrupt
    with NodeClient(node.uri, "/tool") as client:
        eventually(lambda: not client.get_publications())  # its next status closes the server
    assert server.goals == []
    assert not [one for one in caplog.records if one.levelname == "ERROR"]


def test_one_refusal_is_raised_as_it_is_and_the_others_stand(
    master: Master, node: Node, asked: Asked
) -> None:
    asked.refuse["/b"] = "no /b here"
    with pytest.raises(MasterError) as caught, node.batch():
        publisher, subscriber, _ = opened(node)
    assert type(caught.value) is MasterError
    assert (caught.value.method, caught.value.code, caught.value.text) == (
        "registerSubscriber",
        -1,
        "no /b here",
    )
    assert subscriber.closed
    assert not publisher.closed
    assert [name for name in ("/a", "/b", "/c") if registered(master, name)] == ["/a", "/c"]
    assert told_again(node, asked) == []


def test_several_refusals_keep_the_facts_of_each(master: Master, node: Node, asked: Asked) -> None:
    asked.refuse.update({"/a": "not this", "/c": "nor that"})
    with (
        pytest.raises(RegistrationsRefused, match=r"2 of 3 .*not this.*nor that") as caught,
        node.batch(),
    ):
        opened(node)
    assert list(caught.value.refused) == [("publisher", "/a"), ("service", "/c")]
    assert caught.value.refused["service", "/c"].text == "nor that"
    assert (caught.value.method, caught.value.text) == ("registerPublisher", "not this")
    assert [name for name in ("/a", "/b", "/c") if registered(master, name)] == ["/b"]
    assert told_again(node, asked) == []


def test_an_answer_that_is_none_costs_that_registration_only(node: Node, asked: Asked, monkeypatch) -> None:
    monkeypatch.setattr(MasterClient, "multicall", lambda *_, **__: [[], "no list", 1])
    with pytest.raises(RemoteProtocolError, match="registerSubscriber"), node.batch():
        _, subscriber, _ = opened(node)
    assert subscriber.closed


def test_a_master_that_is_away_closes_all_of_it_and_is_told_later(
    master: Master, node: Node, asked: Asked
) -> None:
    """It may have heard of them: what it could not be told to take back is told when it answers."""
    asked.instead = ConnectionLost("away")
    with pytest.raises(ConnectionLost), node.batch():
        publisher, subscriber, _ = opened(node)
    assert publisher.closed
    assert subscriber.closed
    asked.instead = None
    node.check_master_now()
    taken_back = {"unregisterPublisher", "unregisterSubscriber", "unregisterService"}
    eventually(lambda: taken_back <= set(asked.methods))
    assert told_again(node, asked) == []


def test_a_master_without_multicall_is_told_one_by_one_and_not_asked_again(
    master: Master, node: Node, asked: Asked
) -> None:
    asked.instead = MasterError("system.multicall", 1, "no such method")
    with node.batch():
        opened(node)
    asked.instead = AssertionError("asked again")  # type: ignore[assignment]
    with node.batch():
        node.publisher("/d", "std_msgs/String")
    assert [m for m in asked.methods if m.startswith("register")] == [
        "registerPublisher",
        "registerSubscriber",
        "registerService",
        "registerPublisher",
    ]
    assert all(registered(master, name) for name in ("/a", "/b", "/c", "/d"))


def test_a_node_that_is_closed_meanwhile_says_so(master: Master) -> None:
    node = Node("/n", master_uri=master.uri, host="127.0.0.1")
    block = node.batch()
    block.__enter__()
    node.publisher("/a", "std_msgs/String")
    node.close()
    with pytest.raises(LocalProtocolError, match="closed in the meantime"):
        block.__exit__(None, None, None)
    assert not registered(master, "/a")


def test_a_node_says_what_every_node_has_in_one_request(master: Master, monkeypatch) -> None:
    """/rosout and the two services of loggers."""
    told: list[list[str]] = []
    multicall = MasterClient.multicall

    def noted(self: MasterClient, calls: Any, **options: Any) -> Any:
        told.append([method for method, _ in calls])
        return multicall(self, calls, **options)

    monkeypatch.setattr(MasterClient, "multicall", noted)
    with Node("/n", master_uri=master.uri, host="127.0.0.1"):
        assert ["registerPublisher", "registerService", "registerService"] in told
        assert registered(master, "/n/get_loggers")
