"""Topics that fail: wrong types and values, peers that misbehave, links that break."""

from __future__ import annotations

import contextlib
import logging
import socket
import statistics
import struct
import time
from typing import Any

import numpy as np
import pytest

from rosproto.codec import message_class
from rosproto.errors import (
    CodecError,
    LocalProtocolError,
    Md5sumMismatch,
    RosTimeout,
)
from rosproto.master import Master
from rosproto.node import Node
from rosproto.node.graph.slave_client import NodeClient
from rosproto.protocol.handshake import decode_header, encode_header
from rosproto.protocol.wire_limits import Limits
from tests.support.proxy import FaultProxy
from tests.support.victim import eventually

String, Twist = "std_msgs/String", "geometry_msgs/Twist"


def test_an_http_request_to_the_topics_port_is_no_warning(
    nodes: tuple[Node, Node], caplog: pytest.LogCaptureFixture
) -> None:
    """A master calls a node that died, at a port that is ours by now: told that nobody is there, and no more."""
    port = nodes[0].tcpros_address[1]
    with caplog.at_level(logging.INFO), socket.create_connection(("127.0.0.1", port), 5) as sock:
        sock.sendall(b"POST /RPC2 HTTP/1.1\r\nHost: h\r\nContent-length: 0\r\n\r\n")
        assert sock.recv(100).startswith(b"HTTP/1.1 404 Not Found\r\n")
    assert not caplog.records


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
    with pytest.raises(LocalProtocolError, match="specific type"):
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


class RawSubscriber:
    """A subscriber of sockets alone: connects, answers the handshake, and reads when told."""

    def __init__(self, node: Node, topic: str, md5sum: str = "*", type_name: str = "*") -> None:
        port = node.tcpros_address[1]
        self.sock = socket.create_connection(("127.0.0.1", port), 20)
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
        times = []
        for n in range(100):
            began = time.monotonic()
            publisher.publish(data=np.full(300_000, n, "u1"))
            times.append(time.monotonic() - began)
            assert good.next(20).data[0] == n
        assert statistics.median(times) < 0.5  # that it waited would show in most
        by_peer = {link.peer: link for link in publisher.stats()}
        assert by_peer["/raw"].queued <= 4
        assert by_peer["/raw"].dropped > 50
        assert by_peer["/q"].dropped == 0
        # What it reads when it wakes up is in step: whole messages, the newest last.
        stuck.sock.settimeout(20)
        last = 0
        while last != 99:
            (size,) = struct.unpack("<I", stuck._read(4))
            last = stuck._read(size)[-1]
        stuck.sock.close()


def test_a_silent_connection_delays_no_other(master: Master) -> None:
    """rospy's accept loop would wait for its header; here the next subscriber is served at once."""
    limits = Limits(handshake_seconds=60.0)  # longer than the next one waits
    with Node("/p", master_uri=master.uri, rosout=False, limits=limits) as node:
        node.publisher("/quick", String, latch=True).publish(data="x")
        with (
            socket.create_connection(("127.0.0.1", node.tcpros_address[1])),
            socket.create_connection(("127.0.0.1", node.tcpros_address[1])) as half,
        ):
            half.sendall(b"\x10\0\0")
            RawSubscriber(node, "/quick").sock.close()


@pytest.mark.parametrize(
    "garbage",
    [b"\xff\xff\xff\xff", b"\0\0\0\0", b"GET / HTTP/1.0\r\n\r\n", b"\x08\0\0\0\xff\xff\xff\xffabcd", b""],
)
def test_garbage_costs_its_own_connection_only(master: Master, garbage: bytes) -> None:
    """A length of 4 GiB, of 0, another protocol, nothing: closed, and the node goes on."""
    with Node("/p", master_uri=master.uri, rosout=False) as node:
        node.publisher("/alive", String, latch=True).publish(data="x")
        with socket.create_connection(("127.0.0.1", node.tcpros_address[1]), 5) as sock:
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

        def refused() -> bool:
            with pytest.raises(RosTimeout) as caught:
                publisher.wait_for_connection(0.01)
            return "refused" in str(caught.value)

        eventually(refused)  # noted after the peer was told


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
def test_a_broken_link_is_made_again_with_a_fresh_request(
    master: Master, how: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The connection dies though both nodes live."""
    with (
        Node("/p", master_uri=master.uri, rosout=False) as a,
        Node("/q", master_uri=master.uri, rosout=False, intraprocess=False) as b,
        FaultProxy("127.0.0.1", a.tcpros_address[1]) as proxy,
    ):
        requests: list[str] = []
        request = NodeClient.request_topic

        def through_the_proxy(client: NodeClient, topic: str, *offered: Any, **options: Any) -> list[Any]:
            requests.append(topic)
            transport, host, _ = request(client, topic, *offered, **options)
            return [transport, host, proxy.port]

        monkeypatch.setattr(NodeClient, "request_topic", through_the_proxy)
        publisher = a.publisher("/again", String)
        subscriber = b.subscriber("/again", String)
        publisher.wait_for_connection()
        publisher.publish(data="before")
        assert subscriber.next(20).data == "before"
        (first,) = publisher.stats()
        if how == "reset":
            proxy.reset()
        else:
            proxy.cut_after(3)
            publisher.publish(data="cut")

        def again() -> bool:
            """The publisher counts a link a moment after the subscriber does, and may not miss the first yet."""
            links = [link.address for link in publisher.stats()]
            return len(requests) == 2 and subscriber.connections == 1 and links not in ([], [first.address])

        eventually(again)
        publisher.publish(data="after")
        assert subscriber.next(20).data == "after"
        assert subscriber.stats()[0].reconnects == 1


def test_publisher_updates_twice_late_and_empty(master: Master) -> None:
    """The newest list counts; the same list changes nothing; an empty one ends every link."""
    with (
        Node("/p", master_uri=master.uri, rosout=False) as a,
        Node("/q", master_uri=master.uri, rosout=False, intraprocess=False) as b,
    ):
        publisher = a.publisher("/list", String)
        subscriber = b.subscriber("/list", String)
        publisher.wait_for_connection()
        connected = [(link.address, link.reconnects) for link in publisher.stats()]
        with NodeClient(b.uri, "/master") as told:
            for uri in (a.uri, a.uri.rstrip("/"), a.uri.upper().replace("HTTP", "http")):
                told.publisher_update("/list", [uri])
            assert [(link.address, link.reconnects) for link in publisher.stats()] == connected
            assert [link.reconnects for link in subscriber.stats()] == [0]
            told.publisher_update("/list", [])
            told.publisher_update("/unknown", [a.uri])  # is answered, and changes nothing
        eventually(lambda: subscriber.connections == 0)
        eventually(lambda: publisher.connections == 0)


@pytest.mark.parametrize("wrong", [5, "heard", ["heard"]])
def test_a_callback_that_cannot_be_called_is_an_error_at_once(master: Master, wrong: Any) -> None:
    """A queue size in its place, most often; nothing is registered."""
    with Node("/n", master_uri=master.uri, rosout=False) as node:
        for call in (
            lambda: node.subscriber("/t", String, wrong),
            lambda: node.subscriber("/t", String, on_error=wrong),
            lambda: node.publisher("/t", String, on_connect=wrong),
            lambda: node.publisher("/t", String, on_disconnect=wrong),
            lambda: node.publisher("/t", String, header=wrong),
            lambda: node.params.subscribe("/t", wrong),
        ):
            with pytest.raises(TypeError, match=r"/t must be a function, not "):
                call()
        assert node.master.get_system_state().nodes == []
