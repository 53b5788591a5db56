"""The first call of a callback: in a thread of the library, latched messages first, and quick constructors."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from rosproto.action import ActionClient, ActionServer
from rosproto.codec import message_class
from rosproto.codec.generated_source import Source
from rosproto.errors import RosTimeout
from rosproto.master import Master
from rosproto.msg import bundled
from rosproto.node import Node
from rosproto.node.incoming.delivery import Delivery
from rosproto.node.incoming.subscription import Subscription
from tests.support.victim import eventually

String = "std_msgs/String"


@pytest.mark.parametrize("inline", [False, True])
def test_the_thread_that_subscribes_calls_nothing(nodes: tuple[Node, Node], inline: bool) -> None:
    """A second subscriber gets the latched message that the first had, and may hold a lock meanwhile."""
    a, b = nodes
    a.publisher("/kept", String, latch=True).publish(data="x")
    with b.subscriber("/kept", String) as other:
        other.next(20)
        lock, seen = threading.Lock(), []

        def callback(message: Any) -> None:
            with lock:
                seen.append((message.data, threading.get_ident()))

        with lock:
            b.subscriber("/kept", String, callback, inline=inline)
        eventually(lambda: seen)
        assert seen[0][0] == "x"
        assert seen[0][1] != threading.get_ident()


def test_a_second_subscriber_gets_the_latched_message_first(nodes: tuple[Node, Node]) -> None:
    """What comes live meanwhile comes after it."""
    a, b = nodes
    publisher = a.publisher("/kept", String, latch=True)
    publisher.publish(data="0")
    with b.subscriber("/kept", String) as other:
        other.next(20)
        texts: list[str] = []
        b.subscriber("/kept", String, lambda message: texts.append(message.data))
        for number in range(1, 6):
            publisher.publish(data=str(number))
        eventually(lambda: texts[-1:] == ["5"])
        assert texts == sorted(texts)
        assert texts[0] == "0"


def test_a_raw_message_has_its_header_for_who_subscribes_while_the_link_waits_for_it(
    nodes: tuple[Node, Node],
) -> None:
    """A recorder reads the type there; one beside another raw subscriber lost its first messages."""
    a, b = nodes
    publisher = a.publisher("/live", String)
    with b.subscriber("/live", None, raw=True) as other:
        publisher.wait_for_connection(20)
        publisher.publish(data="0")
        other.next(20)
        headers: list[Any] = []
        b.subscriber(
            "/live", None, lambda message: headers.append(message._connection_header), raw=True, inline=True
        )
        publisher.publish(data="1")
        eventually(lambda: headers)
    assert headers[0] is not None
    assert headers[0]["type"] == String


@pytest.mark.parametrize("intraprocess", [False, True], ids=["TCPROS", "intraprocess"])
@pytest.mark.parametrize(
    ("owner", "name", "expected"),
    [(Subscription, "hand_out", ["old", "new"]), (Delivery, "deliver", ["new"])],
    ids=["before it is kept", "after"],
)
def test_who_subscribes_while_a_latched_message_arrives_gets_it_once(
    nodes: tuple[Node, Node],
    monkeypatch: pytest.MonkeyPatch,
    intraprocess: bool,
    owner: type,
    name: str,
    expected: list[str],
) -> None:
    """Not only the one before it, which would stay for ever; and not this one twice."""
    a, _ = nodes
    with Node("/here", master_uri=a.master_uri, rosout=False, intraprocess=intraprocess) as node:
        publisher = (node if intraprocess else a).publisher("/kept", String, latch=True)
        publisher.publish(data="old")
        first = node.subscriber("/kept", String)
        assert first.next(20).data == "old"
        original = getattr(owner, name)
        came: list[Any] = []

        def meanwhile(*words: Any) -> None:
            if not came:
                came.append(node.subscriber("/kept", String, queue_size=10))
            original(*words)

        monkeypatch.setattr(owner, name, meanwhile)
        publisher.publish(data="new")
        assert first.next(20).data == "new"
        (second,) = came
        assert [second.next(20).data for _ in expected] == expected
        with pytest.raises(RosTimeout):
            second.next(0.1)


@pytest.fixture
def generated(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, str]]:
    """The functions that the thread of the test generates: (function, type)."""
    names: list[tuple[str, str]] = []
    ours, original = threading.get_ident(), Source.compile

    def compile_(source: Source, name: str, type_name: str) -> Any:
        if threading.get_ident() == ours:
            names.append((name, type_name))
        return original(source, name, type_name)

    monkeypatch.setattr(Source, "compile", compile_)
    return names


def test_a_decoder_is_made_by_the_link(generated: list[tuple[str, str]]) -> None:
    """It takes 2 ms, and no constructor waits for that."""
    new = message_class("sensor_msgs/CameraInfo", bundled().fork())  # nobody has used this class before
    with Master() as master, Node("/n", master_uri=master.uri, rosout=False) as node:
        node.subscriber("/nobody", new)
        assert generated == []


@pytest.mark.parametrize(
    "type_name", ["std_msgs/String", "geometry_msgs/PoseStamped", "sensor_msgs/LaserScan"]
)
def test_the_first_message_waits_for_no_generated_code(
    nodes: tuple[Node, Node], generated: list[tuple[str, str]], type_name: str
) -> None:
    """The encoder takes up to 3 ms: it is there when the subscriber is."""
    a, b = nodes
    new = message_class(type_name, bundled().fork())  # nobody has used this class before
    with b.subscriber("/t", type_name) as subscriber, a.publisher("/t", new) as publisher:
        assert generated == []  # no constructor waits for it either
        publisher.wait_for_connection(20)
        publisher.publish(new())
        publisher.publish()
        assert generated == []
        subscriber.next(20)


@pytest.mark.parametrize("nodes", [False], indirect=True, ids=["TCPROS"])
def test_the_first_goal_waits_for_no_generated_code(
    nodes: tuple[Node, Node], generated: list[tuple[str, str]]
) -> None:
    """It took 2 to 3 ms, and under load the server's answer came before `send_goal` had returned."""
    a, b = nodes
    new = message_class("woosh_msgs/StepControlAction", bundled().fork())
    with (
        ActionServer(a, "/step", "woosh_msgs/StepControl", lambda goal: None),
        ActionClient(b, "/step", new) as client,
    ):
        client.wait_for_server(20)
        generated.clear()  # what the constructor made
        handle = client.send_goal({"mode": 1})
        assert generated == []
        handle.wait(20)
