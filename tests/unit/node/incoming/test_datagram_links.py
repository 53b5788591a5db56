"""Topics in datagrams between two nodes: like TCPROS in everything but what gets lost."""

from __future__ import annotations

import errno
import logging
import socket
import struct
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto.codec import message_class
from rosproto.errors import CodecError, MasterError, Md5sumMismatch, RosTimeout
from rosproto.master import Master
from rosproto.msg import bundled
from rosproto.node import MasterClient, Node
from rosproto.node.graph.master_client import SystemState
from rosproto.node.graph.slave_client import NodeClient
from rosproto.node.incoming import udpros_link
from rosproto.node.master_monitor import MasterMonitor
from rosproto.node.outgoing.datagram_link import DatagramLink
from rosproto.node.outgoing.frames import LargeFrame
from rosproto.protocol.udpros import DatagramRequest, Reassembly
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.deadline import SleepDetector
from tests.support.victim import eventually


@pytest.fixture
def nodes(master: Master, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Node, Node]]:
    """A publisher's node and a subscriber's."""
    monkeypatch.setattr(udpros_link, "QUIET_SECONDS", 0.3)
    options: Any = {"master_uri": master.uri, "intraprocess": False, "rosout": False, "anonymous": True}
    with Node("/talker", **options) as talker, Node("/listener", **options) as listener:
        yield talker, listener


def only_link(node: Node) -> Any:
    (stats,) = node.stats().links
    return stats


def connections(node: Node) -> list[int]:
    """The numbers of a node's connections, which its datagrams carry."""
    with NodeClient(node.uri, "/test") as client:
        return [row.connection_id for row in client.get_bus_info()]


def parse_address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    return host, int(port)


def test_messages_of_any_size_and_latched(nodes: tuple[Node, Node]) -> None:
    talker, listener = nodes
    publisher = talker.publisher("/words", "std_msgs/String", latch=True)
    publisher.publish(data="latched")
    subscriber = listener.subscriber("/words", "std_msgs/String", unreliable=True)
    assert subscriber.next(timeout=10).data == "latched"
    for text in ("", "x" * 1472, "y" * 50_000):
        publisher.publish(data=text)
        publisher.flush()
        assert subscriber.next(timeout=10).data == text
    incoming, outgoing = only_link(listener), only_link(talker)
    assert (incoming.transport, incoming.messages, incoming.dropped) == ("UDPROS", 4, 0)
    assert (outgoing.transport, outgoing.messages, outgoing.bytes) == ("UDPROS", 4, incoming.bytes)
    with NodeClient(talker.uri, "/test") as client:
        (row,) = client.get_bus_info()
    assert (row.destination, row.transport, row.connected) == (listener.name, "UDPROS", True)


@pytest.mark.promise("A subscriber takes datagrams only after `unreliable=True`")
def test_who_does_not_ask_for_datagrams_gets_none(nodes: tuple[Node, Node]) -> None:
    """From the same publisher that sends them to who asks."""
    talker, listener = nodes
    talker.publisher("/words", "std_msgs/String", latch=True).publish(data="latched")
    subscriber = listener.subscriber("/words", "std_msgs/String")
    assert subscriber.next(timeout=10).data == "latched"
    assert only_link(listener).transport == "TCPROS"


def test_a_type_may_be_learned_or_of_another_revision(nodes: tuple[Node, Node]) -> None:
    talker, listener = nodes
    page = next(r for r in bundled().revisions("woosh_msgs/Battery") if r.label == "page")
    older = message_class("woosh_msgs/Battery", page.library)
    publisher = talker.publisher("/battery", older, latch=True)
    publisher.publish(older(batteryPercentage=81))
    learned = listener.subscriber("/battery", unreliable=True)
    assert learned.next(timeout=10)._md5sum == older._md5sum
    learned.close()
    converted = listener.subscriber("/battery", "woosh_msgs/Battery", unreliable=True)
    assert converted.next(timeout=10).batteryPercentage == 81


def test_another_type_is_refused_with_both_named(nodes: tuple[Node, Node]) -> None:
    talker, listener = nodes
    talker.publisher("/words", "std_msgs/String")
    subscriber = listener.subscriber("/words", "std_msgs/Int32", unreliable=True)
    eventually(lambda: subscriber.errors)
    assert isinstance(subscriber.errors[0], Md5sumMismatch)
    assert subscriber.errors[0].remote_type == "std_msgs/String"


def test_a_publisher_without_datagrams_is_connected_over_tcp(
    nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As rospy is: it takes the second protocol that it is offered."""
    talker, listener = nodes
    request, offers = NodeClient.request_topic, []

    def only_tcp(client: NodeClient, topic: str, offered: Any, **options: Any) -> list[object]:
        offers.append([name for name, *_ in offered])
        return request(client, topic, offered[1:], **options)

    monkeypatch.setattr(NodeClient, "request_topic", only_tcp)
    publisher = talker.publisher("/words", "std_msgs/String", latch=True)
    publisher.publish(data="hello")
    subscriber = listener.subscriber("/words", "std_msgs/String", unreliable=True)
    assert subscriber.next(timeout=10).data == "hello"
    assert only_link(listener).transport == "TCPROS"
    assert offers == [["UDPROS", "TCPROS"]]


def test_a_subscriber_that_leaves_is_noticed(nodes: tuple[Node, Node]) -> None:
    """Its computer refuses what is sent afterwards."""
    talker, listener = nodes
    publisher = talker.publisher("/words", "std_msgs/String")
    subscriber = listener.subscriber("/words", "std_msgs/String", unreliable=True)
    publisher.wait_for_connection(timeout=10)
    subscriber.close()
    publisher.publish(data="anybody?")
    if sys.platform == "win32":  # Wine tells only who sends again, select and recv say nothing there
        eventually(lambda: publisher.publish(data="anybody?") or publisher.connections == 0)
    eventually(lambda: publisher.connections == 0)


def test_a_publisher_that_forgot_us_is_asked_again(master: Master, nodes: tuple[Node, Node]) -> None:
    """After some silence; one that has us still is left alone."""
    talker, listener = nodes
    publisher = talker.publisher("/words", "std_msgs/String")
    subscriber = listener.subscriber("/words", "std_msgs/String", unreliable=True)
    publisher.wait_for_connection(timeout=10)
    listener.publisher("/other", "std_msgs/String")  # the master knows the node still
    (before,) = connections(talker)
    with MasterClient(master.uri, listener.name) as in_its_name:
        in_its_name.unregister_subscriber("/words", listener.uri)
    talker.watch_master(period=60.0, full_check_every=1)
    talker.check_master_now()
    eventually(lambda: connections(talker) != [before])
    publisher.wait_for_connection(timeout=10)
    publisher.publish(data="again")
    assert subscriber.next(timeout=10).data == "again"
    eventually(lambda: only_link(listener).reconnects == 1)


def test_what_came_during_a_slow_answer_is_passed_over(
    nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is late by then."""
    talker, listener = nodes
    publisher = talker.publisher("/words", "std_msgs/String")
    asked = threading.Event()
    ask = NodeClient.get_bus_info

    def slowly(client: NodeClient, **options: Any) -> Any:
        if not asked.is_set():
            publisher.publish(data="late")
            asked.set()
        return ask(client, **options)

    monkeypatch.setattr(udpros_link, "LATE_SECONDS", 0.0)
    monkeypatch.setattr(NodeClient, "get_bus_info", slowly)
    subscriber = listener.subscriber("/words", "std_msgs/String", unreliable=True)
    assert asked.wait(10)
    while True:  # now and then one comes while it is being asked again
        publisher.publish(data="present")
        try:
            assert subscriber.next(timeout=0.1).data == "present"
            break
        except RosTimeout:
            continue


def test_who_asks_again_has_one_connection(nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch) -> None:
    talker, listener = nodes
    publisher = talker.publisher("/words", "std_msgs/String")
    subscriber = listener.subscriber("/words", "std_msgs/String", unreliable=True)
    publisher.wait_for_connection(timeout=10)
    (before,) = connections(talker)
    slept: set[SleepDetector] = set()  # each node notices it once

    def notice(detector: SleepDetector, _meant: float) -> float:
        new = detector not in slept
        slept.add(detector)
        return 3600.0 if new else 0.0

    monkeypatch.setattr(SleepDetector, "slept", notice)
    eventually(lambda: connections(talker) not in ([before], []))
    publisher.publish(data="again")
    assert subscriber.next(timeout=10).data == "again"
    assert publisher.connections == 1


@pytest.mark.promise("with `allow=` only to the addresses in it")
def test_datagrams_of_strangers_change_nothing(
    nodes: tuple[Node, Node], caplog: pytest.LogCaptureFixture
) -> None:
    """Bytes that are not a message of the type are dropped and told of, once; the link lives on."""
    talker, listener = nodes
    publisher = talker.publisher("/words", "std_msgs/String")
    subscriber = listener.subscriber("/words", "std_msgs/String", unreliable=True)
    publisher.wait_for_connection(timeout=10)
    (number,) = connections(talker)
    wrong = struct.pack("<IBBHII", number, 0, 9, 1, 4, 1000)  # a text of 1000 bytes in 4
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        for datagram in (b"noise", wrong, wrong.replace(b"\x09", b"\x0a")):
            stranger.sendto(datagram, parse_address(only_link(talker).address))
    eventually(lambda: subscriber.errors)
    for _ in range(11):  # the numbers 1 to 10 are late: the stranger has used 10
        publisher.publish(data="still here")
    assert subscriber.next(timeout=10).data == "still here"
    assert [type(error) for error in subscriber.errors] == [CodecError]
    assert sum("is dropped" in record.message for record in caplog.records) == 1


@pytest.mark.parametrize("when", ["connected", "quiet"])
def test_closing_ends_the_thread_at_once(nodes: tuple[Node, Node], when: str) -> None:
    talker, listener = nodes
    publisher = talker.publisher("/words", "std_msgs/String")
    subscriber = listener.subscriber("/words", "std_msgs/String", unreliable=True)
    publisher.wait_for_connection(timeout=10)
    (thread,) = (each for each in threading.enumerate() if each.name.startswith("rosproto:/words < "))
    if when == "quiet":
        publisher.close()
    subscriber.close()
    thread.join(5)
    assert not thread.is_alive()


@pytest.mark.promise("with `allow=` only to the addresses in it")
def test_a_request_that_makes_no_sense_or_may_not_be_made(master: Master) -> None:
    """The node says why, and goes on."""
    options: Any = {"allow": ["127.0.0.1"], "limits": Limits(connections=1)}
    with (
        Node("/talker", master_uri=master.uri, rosout=False, anonymous=True, **options) as talker,
        NodeClient(talker.uri, "/test") as client,
    ):
        talker.publisher("/words", "std_msgs/String")

        def protocol(host: str, caller_id: str) -> list[object]:
            header = {"callerid": caller_id, "md5sum": "*", "topic": "/words", "type": "*"}
            return DatagramRequest(header, host, 4000, 1500).as_protocol()

        assert client.request_topic("/words", [protocol("127.0.0.1", "/one")])[0] == "UDPROS"
        for request, why in (
            (["UDPROS"], "is \\[UDPROS"),
            (protocol("127.0.0.2", "/other"), "127.0.0.2 is not allowed to connect"),
            (protocol("127.0.0.1", "/two"), "1 connections already"),
        ):
            with pytest.raises(MasterError, match=why):
                client.request_topic("/words", [request])
        assert [link.peer for link in talker.stats().links] == ["/one"]


# -- the publisher's side alone -----------------------------------------------------------------------------


class Socket:
    """Takes datagrams, or does not."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []
        self.error: Exception | None = None

    def setblocking(self, blocking: bool) -> None: ...

    def send(self, data: bytes) -> int:
        if self.error is not None:
            raise self.error
        self.sent.append(data)
        return len(data)

    def bodies(self) -> list[bytes]:
        reassembly = Reassembly(7, Limits().message_bytes)
        return [body for data in self.sent if (body := reassembly.add(data)) is not None]


class Monitor:
    def __init__(self) -> None:
        self.wanted: list[bool] = []
        self.removed = False

    def add(self, link: DatagramLink) -> None: ...

    def want_write(self, link: DatagramLink, wanted: bool) -> None:
        self.wanted.append(wanted)

    def remove(self, link: DatagramLink) -> None:
        self.removed = True

    def flush_later(self, link: DatagramLink) -> None:
        link.flush()


@pytest.fixture
def parts() -> tuple[DatagramLink, Socket, Monitor]:
    sock, monitor = Socket(), Monitor()
    fakes: dict[str, Any] = {"sock": sock, "monitor": monitor}
    link = DatagramLink(
        **fakes,
        caller_id="/listener",
        address="10.0.0.7:4000",
        topic="/words",
        id=7,
        datagram_bytes=12 + 4,
        queue_size=2,
        on_closed=lambda link, error: None,
    )
    link.start()
    return link, sock, monitor


def frame(body: bytes) -> bytes:
    return struct.pack("<I", len(body)) + body


def test_a_full_socket_keeps_the_newest(parts: tuple[DatagramLink, Socket, Monitor]) -> None:
    """The message under way is finished when it takes more; of those that wait the oldest go."""
    link, sock, monitor = parts
    sock.error = BlockingIOError()
    for text in (b"under way", b"dropped", b"third", b"last"):
        link.send(frame(text))
    with pytest.raises(RosTimeout, match="2 messages wait for /listener"):
        link.wait_empty(0.01)
    sock.error = None
    link.on_writable()
    link.wait_empty(0.01)
    assert sock.bodies() == [b"under way", b"third", b"last"]
    assert (link.stats().dropped, link.stats().messages, link.stats().queued) == (1, 3, 0)
    assert monitor.wanted == [True, False]


def test_a_network_that_is_away_costs_the_message_not_the_link(
    parts: tuple[DatagramLink, Socket, Monitor], caplog: pytest.LogCaptureFixture
) -> None:
    link, sock, monitor = parts
    caplog.set_level(logging.WARNING, "rosproto.node")
    sock.error = OSError(errno.ENETUNREACH, "Network is unreachable")
    for _ in range(3):
        link.send(frame(b"a long message"))
    sock.error = None
    link.send_large(LargeFrame([memoryview(b"back")]))
    assert sock.bodies() == [b"back"]
    assert link.stats().dropped == 3
    assert len(caplog.records) == 1, "told once"
    sock.error = ConnectionRefusedError(errno.ECONNREFUSED, "refused")
    link.send(frame(b"nobody"))
    assert monitor.removed


def test_who_unsubscribed_behind_a_firewall_is_forgotten(
    parts: tuple[DatagramLink, Socket, Monitor],
) -> None:
    """The master tells; who is not known to it at all may be one that a restarted master does not know."""
    link, _, monitor = parts
    for subscribers, others, gone in (
        ({"/words": ["/listener"]}, {}, False),
        ({}, {}, False),
        ({}, {"/chatter": ["/listener"]}, True),
    ):
        MasterMonitor.forget_unsubscribed([link], SystemState(others, subscribers, {}))
        assert monitor.removed is gone
