"""Publishers and subscribers of nodes at a master of ours, over TCP and inside the process."""

from __future__ import annotations

import threading
import time
from typing import Any

import numpy as np
import pytest

from rosproto.codec import AnyMsg, encode, message_class
from rosproto.errors import (
    CodecError,
    ConnectionLost,
    RosTimeout,
)
from rosproto.master import Master
from rosproto.node import EventKind, Node
from rosproto.node.graph.slave_client import NodeClient
from tests.support.proxy import FaultProxy
from tests.support.victim import eventually

String, Twist = "std_msgs/String", "geometry_msgs/Twist"


def test_messages_arrive_in_order_and_unchanged(nodes: tuple[Node, Node]) -> None:
    """A changed message after publish() changes nothing sent, and the publisher's message is not changed."""
    a, b = nodes
    publisher = a.publisher("/order", Twist)
    subscriber = b.subscriber("/order", Twist, queue_size=1000)
    publisher.wait_for_connection()
    message: Any = message_class(Twist)()
    for n in range(500):
        message.linear.x = n
        publisher.publish(message)
    message.linear.x = -1
    assert [subscriber.next(20).linear.x for _ in range(500)] == list(range(500))
    assert subscriber.dropped == 0


def test_large_arrays_are_taken_before_publish_returns(nodes: tuple[Node, Node]) -> None:
    """6 MB of an ndarray that is overwritten at once; what arrives is read-only."""
    a, b = nodes
    publisher = a.publisher("/big", "sensor_msgs/Image")
    subscriber = b.subscriber("/big", None)
    publisher.wait_for_connection()
    for n in range(4):
        data = np.full(6_000_000, n + 1, "u1")
        publisher.publish(data=data)
        data[:] = 0
    images = [subscriber.next(20) for _ in range(4)]
    assert [int(image.data.min()) for image in images] == [1, 2, 3, 4]
    assert [image.header.seq for image in images] == [1, 2, 3, 4]
    assert not images[0].data.flags.writeable
    assert subscriber.type_name == "sensor_msgs/Image"


def test_latched_messages_reach_every_later_subscriber(nodes: tuple[Node, Node]) -> None:
    """Also the second subscriber of a node that has had it already."""
    a, b = nodes
    a.publisher("/kept", String, latch=True).publish(data="x")
    first = b.subscriber("/kept", String)
    assert first.next(20).data == "x"
    assert first.latching
    assert b.subscriber("/kept", String).next(20).data == "x"
    seen: list[str] = []
    b.subscriber("/kept", String, lambda m: seen.append(m.data))
    eventually(lambda: seen == ["x"])


def test_a_publisher_that_the_restarted_master_does_not_know_is_heard_while_it_sends(
    nodes: tuple[Node, Node],
) -> None:
    """Neither roscpp nor rospy registers again after a restart of the master; their connections live on."""
    a, b = nodes
    publisher = a.publisher("/kept3", String)
    subscriber = b.subscriber("/kept3", String)
    publisher.wait_for_connection(5.0)
    eventually(lambda: subscriber.connections == 1)
    subscriber._subscription.update_publishers([], keep_connected=True)  # as a new master's answer
    publisher.publish(data="x")
    assert subscriber.next(20).data == "x"
    publisher.close()
    eventually(lambda: not subscriber.stats())  # it is not looked for for ever
    again = a.publisher("/kept3", String)
    again.wait_for_connection(5.0)
    again.publish(data="y")
    assert subscriber.next(20).data == "y"


def test_a_publisher_that_left_is_let_go_when_the_master_says_so(nodes: tuple[Node, Node]) -> None:
    a, b = nodes
    publisher = a.publisher("/kept4", String)
    subscriber = b.subscriber("/kept4", String)
    publisher.wait_for_connection(5.0)
    eventually(lambda: subscriber.connections == 1)
    with NodeClient(b.uri, "/master") as told:
        told.publisher_update("/kept4", [])
    eventually(lambda: publisher.connections == 0)
    assert subscriber.connections == 0


@pytest.mark.parametrize("raw_first", [False, True])
def test_a_latched_message_reaches_raw_and_decoded_subscribers(
    nodes: tuple[Node, Node], raw_first: bool
) -> None:
    """Whoever came first: the later one gets it in its own form."""
    a, b = nodes
    a.publisher("/kept2", String, latch=True).publish(data="x")
    first = b.subscriber("/kept2", None if raw_first else String, raw=raw_first)
    first.next(20)
    second = b.subscriber("/kept2", String, raw=not raw_first).next(20)
    expected = message_class(String)(data="x")
    assert (second == expected) if raw_first else (second._buff == encode(expected))
    assert second._connection_header["latching"] == "1"


def test_several_publishers_are_merged(nodes: tuple[Node, Node]) -> None:
    """Two nodes publish, one subscribes; two subscribers of a node share the links."""
    a, b = nodes
    one, two = a.publisher("/merged", String), b.publisher("/merged", String)
    ours, also = b.subscriber("/merged", String), b.subscriber("/merged", String)
    one.wait_for_connection()
    two.wait_for_connection()
    one.publish(data="one")
    two.publish(data="two")
    assert {ours.next(20).data, ours.next(20).data} == {"one", "two"}
    assert {also.next(20).data, also.next(20).data} == {"one", "two"}
    assert one.connections == 1
    ours.close()
    one.publish(data="three")
    assert also.next(20).data == "three"


@pytest.mark.parametrize("raw", [False, True])
@pytest.mark.parametrize("raw_first", [False, True])
def test_a_second_subscriber_misses_nothing_from_its_first_moment(
    raw_first: bool, raw: bool, nodes: tuple[Node, Node]
) -> None:
    """The link may be waiting for the next message already, on behalf of the first subscriber alone."""
    a, b = nodes
    publisher = a.publisher("/joined", String)
    first = b.subscriber("/joined", String, raw=raw_first)
    publisher.wait_for_connection()
    for number in range(10):
        publisher.publish(data="before")
        first.next(20)
        with b.subscriber("/joined", String, raw=raw) as second:
            publisher.publish(data=str(number))
            message = second.next(20)
            assert isinstance(message, AnyMsg) == raw
            assert message._connection_header["topic"] == "/joined"
            expected = message_class(String)(data=str(number))
            assert (message._buff == encode(expected)) if raw else (message == expected)
        first.next(20)


def test_raw_messages_are_relayed_without_decoding(nodes: tuple[Node, Node]) -> None:
    """AnyMsg in, AnyMsg out; header.seq of a relayed message stays."""
    a, b = nodes
    source = a.publisher("/in", "sensor_msgs/LaserScan")
    relay_in, relay_out = b.subscriber("/in", raw=True), b.publisher("/out", "sensor_msgs/LaserScan")
    end = a.subscriber("/out", "sensor_msgs/LaserScan")
    source.wait_for_connection()
    relay_out.wait_for_connection()
    for _ in range(3):
        source.publish(ranges=[1.0, 2.0])
    for seq in (1, 2, 3):
        raw = relay_in.next(20)
        assert isinstance(raw, AnyMsg)
        assert raw._connection_header["type"] == "sensor_msgs/LaserScan"
        relay_out.publish(raw)
        scan = end.next(20)
        assert scan.header.seq == seq
        assert list(scan.ranges) == [1.0, 2.0]


def test_any_message_to_any_subscriber(nodes: tuple[Node, Node]) -> None:
    """A relay that never knows a type: latched and live, small and large; a typed subscriber is told why not."""
    a, b = nodes
    publisher = a.publisher("/any", AnyMsg, latch=True)
    publisher.publish(AnyMsg(_buff=b"kept"))
    subscriber = b.subscriber("/any", AnyMsg)
    assert subscriber.next(20)._buff == b"kept"
    large = bytes(range(256)) * 4000
    for sent in (AnyMsg(_buff=b"live"), b"bytes", AnyMsg(_buff=large)):
        publisher.publish(sent)
        received = subscriber.next(20)
        assert type(received) is AnyMsg
        assert received._buff == getattr(sent, "_buff", sent)
        assert received._connection_header["type"] == "*"
    with pytest.raises(CodecError, match="std_msgs/String"):
        publisher.publish(message_class(String)(data="x"))
    with a.subscriber("/any", String) as typed:
        eventually(lambda: typed.errors)
        assert "AnyMsg" in str(typed.errors[0]) or "offers *" in str(typed.errors[0])


def test_the_type_of_any_message_cannot_be_learned(nodes: tuple[Node, Node]) -> None:
    """Decoding whatever comes needs a type; the error says how to get the bytes."""
    a, b = nodes
    a.publisher("/untold", AnyMsg)
    with b.subscriber("/untold") as subscriber:
        eventually(lambda: subscriber.errors)
        assert "subscribe with AnyMsg" in str(subscriber.errors[0])


def test_raw_and_decoded_subscribers_share_a_topic(nodes: tuple[Node, Node]) -> None:
    """Each gets what it asked for."""
    a, b = nodes
    publisher = a.publisher("/both", String)
    raw, decoded = b.subscriber("/both", raw=True), b.subscriber("/both", String)
    publisher.wait_for_connection()
    publisher.publish(data="hi")
    assert decoded.next(20).data == "hi"
    assert raw.next(20)._buff == encode(message_class(String)(data="hi"))


def test_queue_size_one_is_the_newest_message(nodes: tuple[Node, Node]) -> None:
    """A callback that was held up sees the newest message next, not a backlog."""
    a, b = nodes
    publisher = a.publisher("/newest", "std_msgs/UInt32")
    gate, seen, done = threading.Event(), [], threading.Event()

    def callback(message: Any) -> None:
        seen.append(message.data)
        if message.data == 2:
            gate.wait(20)
        if message.data == 1000:
            done.set()
        if message.data == 1:
            time.sleep(0.06)  # surely slow: from now on it has a thread

    subscriber = b.subscriber("/newest", "std_msgs/UInt32", callback, queue_size=1)
    publisher.wait_for_connection()
    before = threading.enumerate()
    publisher.publish(data=1)
    eventually(
        lambda: "rosproto:callback /newest" in [t.name for t in threading.enumerate() if t not in before]
    )
    publisher.publish(data=2)
    eventually(lambda: 2 in seen)
    for n in range(3, 1001):
        publisher.publish(data=n)
    eventually(lambda: subscriber.latest.data == 1000)
    gate.set()
    assert done.wait(20)
    assert seen == [1, 2, 1000]


def test_closing_in_the_callback_ends_it(nodes: tuple[Node, Node]) -> None:
    """No call after that, and no deadlock."""
    a, b = nodes
    seen: list[str] = []
    publisher = a.publisher("/once", String)

    def callback(message: Any) -> None:
        seen.append(message.data)
        subscriber.close()

    subscriber = b.subscriber("/once", String, callback)
    publisher.wait_for_connection()
    for word in ("a", "b", "c"):
        publisher.publish(data=word)
    eventually(lambda: publisher.connections == 0)
    assert seen == ["a"]


def test_iteration_ends_when_the_node_closes(master: Master) -> None:
    """A loop over messages in another thread comes to its end; a waiting next() raises."""
    node = Node("/iterating", master_uri=master.uri, rosout=False)
    subscriber, other = node.subscriber("/nothing", String), node.subscriber("/nothing2", String)
    ended, raised = threading.Event(), threading.Event()

    def loop() -> None:
        for _ in subscriber:
            pass
        ended.set()

    def wait() -> None:
        try:
            other.next(20)
        except ConnectionLost:
            raised.set()

    for target in (loop, wait):
        threading.Thread(target=target, daemon=True).start()
    node.close()
    assert ended.wait(20)
    assert raised.wait(20)


def test_a_publisher_that_comes_later_or_leaves(nodes: tuple[Node, Node]) -> None:
    """The master's list is the truth: links come and go with it."""
    a, b = nodes
    subscriber = b.subscriber("/late", String)
    assert subscriber.connections == 0
    with pytest.raises(RosTimeout, match="no publisher is registered"):
        subscriber.next(0.01)
    for word in ("first", "second"):
        with a.publisher("/late", String) as publisher:
            publisher.wait_for_connection()
            publisher.publish(data=word)
            assert subscriber.next(20).data == word
        eventually(lambda: not subscriber.stats())


def test_wait_for_message_takes_one_and_leaves(nodes: tuple[Node, Node]) -> None:
    """Subscribed only as long as it waits; the timeout says what was missing."""
    a, b = nodes
    publisher = a.publisher("/single", String, latch=True)
    publisher.publish(data="here")
    assert b.wait_for_message("/single", String, timeout=20).data == "here"
    eventually(lambda: publisher.connections == 0)
    with b.subscriber("/nobody", String), pytest.raises(RosTimeout, match="no publisher is registered"):
        b.wait_for_message(
            "/nobody", String, timeout=0.01
        )  # registered already: no call to the master is waited for


def test_events_tell_of_links(master: Master, monkeypatch: pytest.MonkeyPatch) -> None:
    """Connected and disconnected, on both sides."""
    seen: list[tuple[EventKind, str, str]] = []
    with (
        Node(
            "/p",
            master_uri=master.uri,
            rosout=False,
            intraprocess=False,
            on_event=lambda e: seen.append((e.kind, e.name, e.direction)),
        ) as a,
        Node("/q", master_uri=master.uri, rosout=False) as b,
        FaultProxy("127.0.0.1", b.tcpros_address[1]) as proxy,
    ):
        request = NodeClient.request_topic

        def through_the_proxy(client: NodeClient, *given: Any, **options: Any) -> list[object]:
            return [*request(client, *given, **options)[:2], proxy.port]

        monkeypatch.setattr(NodeClient, "request_topic", through_the_proxy)
        publisher = b.publisher("/events", String)
        a.subscriber("/events", String)
        publisher.wait_for_connection()
        eventually(lambda: (EventKind.CONNECTED, "/events", "in") in seen)
        proxy.reset()
        eventually(lambda: (EventKind.DISCONNECTED, "/events", "in") in seen)
        eventually(lambda: seen.count((EventKind.CONNECTED, "/events", "in")) == 2)
