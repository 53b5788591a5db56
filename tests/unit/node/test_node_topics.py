"""Publishers and subscribers of nodes at a master of ours, over TCP and inside the process."""

from __future__ import annotations

import contextlib
import logging
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from rosproto.codec import AnyMsg, encode, message_class
from rosproto.errors import (
    CodecError,
    ConnectionLost,
    LocalProtocolError,
    Md5sumMismatch,
    RosTimeout,
)
from rosproto.master import Master
from rosproto.node import EventKind, Node
from rosproto.protocol.header import decode_header, encode_header
from tests.support.proxy import FaultProxy

String, Twist = "std_msgs/String", "geometry_msgs/Twist"


@pytest.fixture(scope="module")
def master() -> Iterator[Master]:
    with Master() as master:
        yield master


@pytest.fixture(params=[False, True], ids=["tcp", "local"])
def nodes(master: Master, request: pytest.FixtureRequest) -> Iterator[tuple[Node, Node]]:
    """Two nodes that exchange messages over TCP, or in the process."""
    name = f"n{threading.get_ident()}_{time.monotonic_ns()}"
    options: Any = {"master_uri": master.uri, "intraprocess": request.param, "rosout": False}
    with Node(f"/a_{name}", **options) as a, Node(f"/b_{name}", **options) as b:
        yield a, b


def eventually(condition: Callable[[], object], timeout: float = 5.0) -> None:
    """Wait until it holds."""
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.005)


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
    assert [subscriber.next(5).linear.x for _ in range(500)] == list(range(500))
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
    images = [subscriber.next(10) for _ in range(4)]
    assert [int(image.data.min()) for image in images] == [1, 2, 3, 4]
    assert [image.header.seq for image in images] == [1, 2, 3, 4]
    assert not images[0].data.flags.writeable
    assert subscriber.type_name == "sensor_msgs/Image"


def test_latched_messages_reach_every_later_subscriber(nodes: tuple[Node, Node]) -> None:
    """Also the second subscriber of a node that has had it already."""
    a, b = nodes
    a.publisher("/kept", String, latch=True).publish(data="x")
    first = b.subscriber("/kept", String)
    assert first.next(5).data == "x"
    assert first.latching
    assert b.subscriber("/kept", String).next(5).data == "x"
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
    assert subscriber.next(5).data == "x"
    publisher.close()
    eventually(lambda: not subscriber._subscription.links)  # it is not looked for for ever
    again = a.publisher("/kept3", String)
    again.wait_for_connection(5.0)
    again.publish(data="y")
    assert subscriber.next(5).data == "y"


def test_a_publisher_that_left_is_let_go_when_the_master_says_so(nodes: tuple[Node, Node]) -> None:
    a, b = nodes
    publisher = a.publisher("/kept4", String)
    subscriber = b.subscriber("/kept4", String)
    publisher.wait_for_connection(5.0)
    eventually(lambda: subscriber.connections == 1)
    subscriber._subscription.update_publishers([])
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
    first.next(5)
    second = b.subscriber("/kept2", String, raw=not raw_first).next(5)
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
    assert {ours.next(5).data, ours.next(5).data} == {"one", "two"}
    assert {also.next(5).data, also.next(5).data} == {"one", "two"}
    assert one.connections == 1
    ours.close()
    one.publish(data="three")
    assert also.next(5).data == "three"


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
        first.next(5)
        with b.subscriber("/joined", String, raw=raw) as second:
            publisher.publish(data=str(number))
            message = second.next(5)
            assert isinstance(message, AnyMsg) == raw
            assert message._connection_header["topic"] == "/joined"
            expected = message_class(String)(data=str(number))
            assert (message._buff == encode(expected)) if raw else (message == expected)
        first.next(5)


def test_an_http_request_to_the_topics_port_is_no_warning(
    nodes: tuple[Node, Node], caplog: pytest.LogCaptureFixture
) -> None:
    """A master calls a node that died, at a port that is ours by now: told that nobody is there, and no more."""
    port = nodes[0]._tcpros.port
    with caplog.at_level(logging.INFO), socket.create_connection(("127.0.0.1", port), 5) as sock:
        sock.sendall(b"POST /RPC2 HTTP/1.1\r\nHost: h\r\nContent-length: 0\r\n\r\n")
        assert sock.recv(100).startswith(b"HTTP/1.1 404 Not Found\r\n")
    assert not caplog.records


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
        raw = relay_in.next(5)
        assert isinstance(raw, AnyMsg)
        assert raw._connection_header["type"] == "sensor_msgs/LaserScan"
        relay_out.publish(raw)
        scan = end.next(5)
        assert scan.header.seq == seq
        assert list(scan.ranges) == [1.0, 2.0]


def test_raw_and_decoded_subscribers_share_a_topic(nodes: tuple[Node, Node]) -> None:
    """Each gets what it asked for."""
    a, b = nodes
    publisher = a.publisher("/both", String)
    raw, decoded = b.subscriber("/both", raw=True), b.subscriber("/both", String)
    publisher.wait_for_connection()
    publisher.publish(data="hi")
    assert decoded.next(5).data == "hi"
    assert raw.next(5)._buff == encode(message_class(String)(data="hi"))


def test_another_md5sum_is_refused_on_both_sides(nodes: tuple[Node, Node]) -> None:
    """The subscriber's error says which; `next` names it; both sides see an event."""
    a, b = nodes
    told: list[Exception] = []
    publisher = a.publisher("/typed", String)
    wrong = b.subscriber("/typed", "std_msgs/Int32", on_error=told.append)
    eventually(lambda: wrong.errors)
    assert isinstance(wrong.errors[0], Md5sumMismatch)
    assert told == wrong.errors
    with pytest.raises(RosTimeout, match="md5sum"):
        wrong.next(0.05)
    assert publisher.connections == 0


def test_the_same_topic_with_another_type_is_an_error(nodes: tuple[Node, Node]) -> None:
    """In one node; the old object stays as it was."""
    a, _ = nodes
    a.publisher("/one_type", String)
    a.subscriber("/one_type", String)
    with pytest.raises(LocalProtocolError, match="std_msgs/String"):
        a.publisher("/one_type", "std_msgs/Int32")
    with pytest.raises(LocalProtocolError, match="std_msgs/String"):
        a.subscriber("/one_type", "std_msgs/Int32")
    with pytest.raises(LocalProtocolError, match="definite type"):
        a.publisher("/no_type", None)


def test_wrong_values_are_told_to_the_publisher(nodes: tuple[Node, Node]) -> None:
    """A value that does not fit, and a message of another type."""
    a, b = nodes
    publisher = a.publisher("/values", "std_msgs/UInt8")
    b.subscriber("/values")
    publisher.wait_for_connection()
    with pytest.raises(CodecError, match="data"):
        publisher.publish(data=300)
    with pytest.raises(CodecError, match="std_msgs/String"):
        publisher.publish(message_class(String)(data="x"))
    publisher.close()
    with pytest.raises(LocalProtocolError, match="closed"):
        publisher.publish(data=1)


def test_queue_size_one_is_the_newest_message(nodes: tuple[Node, Node]) -> None:
    """A callback that was held up sees the newest message next, not a backlog."""
    a, b = nodes
    publisher = a.publisher("/newest", "std_msgs/UInt32")
    gate, seen, done = threading.Event(), [], threading.Event()

    def callback(message: Any) -> None:
        seen.append(message.data)
        if message.data == 2:
            gate.wait(5)
        if message.data == 1000:
            done.set()
        if message.data == 1:
            time.sleep(0.01)  # slow once: from now on it has a thread

    subscriber = b.subscriber("/newest", "std_msgs/UInt32", callback, queue_size=1)
    publisher.wait_for_connection()
    publisher.publish(data=1)
    eventually(lambda: subscriber._runner is not None and subscriber._runner.has_thread)
    publisher.publish(data=2)
    eventually(lambda: 2 in seen)
    for n in range(3, 1001):
        publisher.publish(data=n)
    eventually(lambda: subscriber.latest.data == 1000)
    gate.set()
    assert done.wait(5)
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
    assert ended.wait(5)
    assert raised.wait(5)


# -- peers that misbehave ------------------------------------------------------------------------------------


class RawSubscriber:
    """A subscriber of sockets alone: connects, answers the handshake, and reads when told."""

    def __init__(self, node: Node, topic: str, md5sum: str = "*", type_name: str = "*") -> None:
        port = node._tcpros.port
        self.sock = socket.create_connection(("127.0.0.1", port), 5)
        self.sock.sendall(
            encode_header({"callerid": "/raw", "topic": topic, "md5sum": md5sum, "type": type_name})
        )
        (size,) = struct.unpack("<I", self._read(4))
        self.header = decode_header(self._read(size))

    def _read(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            data += self.sock.recv(size - len(data))
        return data


def test_a_stuck_subscriber_blocks_nobody(master: Master) -> None:
    """publish() returns at once, its queue drops the oldest, and the other subscriber gets everything."""
    with (
        Node("/p", master_uri=master.uri, rosout=False) as a,
        Node("/q", master_uri=master.uri, rosout=False, intraprocess=False) as b,
    ):
        publisher = a.publisher("/stuck", "std_msgs/UInt8MultiArray", queue_size=3)
        good = b.subscriber("/stuck", queue_size=1000)
        publisher.wait_for_connection()
        stuck = RawSubscriber(a, "/stuck")
        publisher.wait_for_connection(count=2)
        slowest = 0.0
        for n in range(100):
            began = time.monotonic()
            publisher.publish(data=np.full(300_000, n, "u1"))
            slowest = max(slowest, time.monotonic() - began)
            assert good.next(5).data[0] == n
        assert slowest < 1.0
        by_peer = {link.peer: link for link in publisher.stats()}
        assert by_peer["/raw"].queued <= 4
        assert by_peer["/raw"].dropped > 50
        assert by_peer["/q"].dropped == 0
        # What it reads when it wakes up is in step: whole messages, the newest last.
        stuck.sock.settimeout(5)
        last = 0
        while last != 99:
            (size,) = struct.unpack("<I", stuck._read(4))
            last = stuck._read(size)[-1]
        stuck.sock.close()


def test_a_silent_connection_delays_no_other(master: Master) -> None:
    """rospy's accept loop would wait for its header; here the next subscriber is served at once."""
    with Node("/p", master_uri=master.uri, rosout=False) as node:
        node.publisher("/quick", String, latch=True).publish(data="x")
        with (
            socket.create_connection(("127.0.0.1", node._tcpros.port)),
            socket.create_connection(("127.0.0.1", node._tcpros.port)) as half,
        ):
            half.sendall(b"\x10\0\0")
            began = time.monotonic()
            RawSubscriber(node, "/quick").sock.close()
            assert time.monotonic() - began < 1.0


@pytest.mark.parametrize(
    "garbage",
    [b"\xff\xff\xff\xff", b"\0\0\0\0", b"GET / HTTP/1.0\r\n\r\n", b"\x08\0\0\0\xff\xff\xff\xffabcd", b""],
)
def test_garbage_costs_its_own_connection_only(master: Master, garbage: bytes) -> None:
    """A length of 4 GiB, of 0, another protocol, nothing: closed, and the node goes on."""
    with Node("/p", master_uri=master.uri, rosout=False) as node:
        node.publisher("/alive", String, latch=True).publish(data="x")
        with socket.create_connection(("127.0.0.1", node._tcpros.port), 5) as sock:
            sock.sendall(garbage)
            try:
                sock.shutdown(socket.SHUT_WR)
            except OSError:
                pass  # closed already
            try:
                while sock.recv(4096):
                    pass
            except ConnectionResetError:
                pass  # closed with our bytes unread
        assert RawSubscriber(node, "/alive").header["latching"] == "1"


def test_an_unknown_topic_and_a_wrong_md5sum_get_an_error_header(master: Master) -> None:
    """The only field is `error`, as rospy and roscpp have it."""
    with Node("/p", master_uri=master.uri, rosout=False) as node:
        publisher = node.publisher("/there", String)
        assert list(RawSubscriber(node, "/not_there").header) == ["error"]
        header = RawSubscriber(node, "/there", "0" * 32, "std_msgs/Other").header
        assert list(header) == ["error"]
        assert "0" * 32 in header["error"]
        with pytest.raises(RosTimeout, match="refused"):
            publisher.wait_for_connection(0.05)


def test_a_subscriber_that_talks_is_cut_off(master: Master) -> None:
    """A flood after the header costs a bounded amount."""
    with Node("/p", master_uri=master.uri, rosout=False) as node:
        publisher = node.publisher("/talk", String)
        raw = RawSubscriber(node, "/talk")
        publisher.wait_for_connection()
        with contextlib.suppress(OSError):
            for _ in range(100):
                raw.sock.sendall(bytes(10_000))
        eventually(lambda: publisher.connections == 0)
        raw.sock.close()


def test_a_subscriber_that_leaves_is_noticed(master: Master) -> None:
    """FIN and RST, without anything being published."""
    with Node("/p", master_uri=master.uri, rosout=False) as node:
        publisher = node.publisher("/left", String)
        for reset in (False, True):
            raw = RawSubscriber(node, "/left")
            publisher.wait_for_connection()
            if reset:
                raw.sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            raw.sock.close()
            eventually(lambda: publisher.connections == 0)


@pytest.mark.parametrize("how", ["reset", "cut"])
def test_a_broken_link_is_made_again_with_a_fresh_request(master: Master, how: str) -> None:
    """The connection dies though both nodes live: connected again within a second."""
    with (
        Node("/p", master_uri=master.uri, rosout=False) as a,
        Node("/q", master_uri=master.uri, rosout=False, intraprocess=False) as b,
        FaultProxy("127.0.0.1", a._tcpros.port) as proxy,
    ):
        requests: list[str] = []
        answer = a._slave.methods["requestTopic"][0]

        def through_the_proxy(peer: str, caller: str, topic: str, protocols: Any) -> list[Any]:
            requests.append(topic)
            reply = answer(peer, caller, topic, protocols)
            reply[2][2] = proxy.port
            return reply

        a._slave.methods["requestTopic"] = (through_the_proxy, 3, [])
        publisher = a.publisher("/again", String)
        subscriber = b.subscriber("/again", String)
        publisher.wait_for_connection()
        publisher.publish(data="before")
        assert subscriber.next(5).data == "before"
        began = time.monotonic()
        if how == "reset":
            proxy.reset()
        else:
            proxy.cut_after(3)
            publisher.publish(data="cut")
        eventually(lambda: len(requests) == 2 and publisher.connections == 1 and subscriber.connections == 1)
        assert time.monotonic() - began < 1.0
        publisher.publish(data="after")
        assert subscriber.next(5).data == "after"
        assert subscriber.stats()[0].reconnects == 1


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
            assert subscriber.next(5).data == word
        eventually(lambda: not subscriber.stats())


def test_publisher_updates_twice_late_and_empty(master: Master) -> None:
    """The newest list counts; the same list changes nothing; an empty one ends every link."""
    with (
        Node("/p", master_uri=master.uri, rosout=False) as a,
        Node("/q", master_uri=master.uri, rosout=False, intraprocess=False) as b,
    ):
        publisher = a.publisher("/list", String)
        subscriber = b.subscriber("/list", String)
        publisher.wait_for_connection()
        (link,) = subscriber._subscription.links.values()
        update = b._slave.dispatch
        for uri in (a.uri, a.uri.rstrip("/"), a.uri.upper().replace("HTTP", "http")):
            assert update("publisherUpdate", ["/master", "/list", [uri]], "127.0.0.1") == [1, "", 0]
        assert list(subscriber._subscription.links.values()) == [link]
        update("publisherUpdate", ["/master", "/list", []], "127.0.0.1")
        assert subscriber.connections == 0
        eventually(lambda: publisher.connections == 0)
        assert update("publisherUpdate", ["/master", "/unknown", [a.uri]], "127.0.0.1") == [1, "", 0]


def test_wait_for_message_takes_one_and_leaves(nodes: tuple[Node, Node]) -> None:
    """Subscribed only as long as it waits; the timeout says what was missing."""
    a, b = nodes
    publisher = a.publisher("/single", String, latch=True)
    publisher.publish(data="here")
    assert b.wait_for_message("/single", String, timeout=5).data == "here"
    eventually(lambda: publisher.connections == 0)
    with pytest.raises(RosTimeout, match="no publisher is registered"):
        b.wait_for_message("/nobody", timeout=0.01)


def test_events_tell_of_links(master: Master) -> None:
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
    ):
        publisher = b.publisher("/events", String)
        a.subscriber("/events", String)
        publisher.wait_for_connection()
        eventually(lambda: (EventKind.CONNECTED, "/events", "in") in seen)
        for link in b._topics.publication("/events").links:  # type: ignore[union-attr]
            link.close()
        eventually(lambda: (EventKind.DISCONNECTED, "/events", "in") in seen)
        eventually(lambda: seen.count((EventKind.CONNECTED, "/events", "in")) == 2)


@pytest.mark.parametrize("wrong", [5, "heard", ["heard"]])
def test_a_callback_that_cannot_be_called_is_an_error_at_once(master: Master, wrong: Any) -> None:
    """A queue size in its place, most often; nothing is registered."""
    with Node("/n", master_uri=master.uri, rosout=False) as node:
        for call in (
            lambda: node.subscriber("/t", String, wrong),
            lambda: node.subscriber("/t", String, on_error=wrong),
            lambda: node.publisher("/t", String, on_connect=wrong),
            lambda: node.params.subscribe("/t", wrong),
        ):
            with pytest.raises(TypeError, match=r"/t is a function, not "):
                call()
        assert node.master.get_system_state().nodes == []
