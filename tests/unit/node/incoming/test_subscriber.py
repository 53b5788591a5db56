"""What a subscriber tells of its publishers, and how many messages it keeps."""

from __future__ import annotations

import socket
import threading
import time
from xmlrpc.client import ServerProxy

import pytest

from rosproto.node import ConnectedLink, Node
from rosproto.node.incoming import tcpros_link
from tests.support.victim import eventually

UInt32 = "std_msgs/UInt32"


def test_the_publishers_are_told_by_uri_and_name(nodes: tuple[Node, Node]) -> None:
    """Only those whose messages can arrive."""
    a, b = nodes
    subscriber = b.subscriber("/told", UInt32)
    assert subscriber.publisher_uris == {}
    publisher = a.publisher("/told", UInt32)
    subscriber.wait_for_connection(20)
    assert subscriber.publisher_uris == {a.uri: a.name}
    publisher.close()
    eventually(lambda: subscriber.publisher_uris == {}, 5.0)


def test_why_no_message_comes(nodes: tuple[Node, Node]) -> None:
    """In words, for each publisher that the master names."""
    a, b = nodes
    subscriber = b.subscriber("/silent", UInt32)
    assert subscriber.why_silent() == "no publisher is registered at the master"
    a.publisher("/silent", UInt32)
    subscriber.wait_for_connection(20)
    assert subscriber.why_silent() == f"{a.name} is receiving"


def test_a_message_comes_with_the_time_of_its_receipt(nodes: tuple[Node, Node]) -> None:
    """By this computer's clock, whatever the node's clock is."""
    a, b = nodes
    publisher, subscriber = a.publisher("/stamped", UInt32), b.subscriber("/stamped", UInt32)
    publisher.wait_for_connection(20)
    before = time.time()
    publisher.publish(data=7)
    message, stamp = subscriber.next_stamped(20)
    assert message.data == 7
    assert before <= stamp <= time.time()


def test_the_queue_may_be_made_shorter_and_longer(nodes: tuple[Node, Node]) -> None:
    """From the next message on as many wait as it says; the oldest is dropped and counted."""
    a, b = nodes
    publisher, subscriber = a.publisher("/queue", UInt32), b.subscriber("/queue", UInt32, queue_size=10)
    assert (subscriber.queue_size, subscriber.keeps) == (10, 10)
    publisher.wait_for_connection(20)
    subscriber.queue_size = 2
    assert subscriber.keeps == 2
    for n in range(5):
        publisher.publish(data=n)
    eventually(lambda: subscriber.latest is not None and subscriber.latest.data == 4, 5.0)
    assert [subscriber.next(5).data for _ in range(2)] == [3, 4]
    assert subscriber.dropped == 3


def test_a_quick_callback_is_given_all_that_came_at_once(nodes: tuple[Node, Node]) -> None:
    """`keeps` is what deliveries ask; a callback in the link's own thread keeps as many as rospy's."""
    _, b = nodes
    assert b.subscriber("/keeps", UInt32, lambda message: None, queue_size=3).keeps is None
    assert b.subscriber("/keeps", UInt32, lambda message: None, queue_size=3, inline=True).keeps == 3


def test_nodelay_is_asked_for_with_the_next_connection(nodes: tuple[Node, Node]) -> None:
    """It may be changed as long as the topic is subscribed, for all who share it."""
    _, b = nodes
    subscriber = b.subscriber("/nodelay", UInt32, tcp_nodelay=True)
    assert subscriber.tcp_nodelay
    subscriber.tcp_nodelay = False
    assert not b.subscriber("/nodelay", UInt32).tcp_nodelay


def test_the_connected_links_are_told_at_once_and_with_each_change(nodes: tuple[Node, Node]) -> None:
    """One for each publisher; a second subscriber of the topic is told those that are up already."""
    a, b = nodes
    told: list[frozenset[ConnectedLink]] = []
    subscriber = b.subscriber("/linked", UInt32, on_links=told.append)
    assert told == [frozenset()]
    theirs, ours = a.publisher("/linked", UInt32), b.publisher("/linked", UInt32)
    subscriber.wait_for_connection(20, count=2)
    links = told[-1]
    assert sorted(link.node for link in links) == sorted([a.name, b.name])
    assert {link.address for link in links} == {link.address for link in subscriber.stats()}
    late: list[frozenset[ConnectedLink]] = []
    b.subscriber("/linked", UInt32, on_links=late.append)
    assert late == [links]
    ours.close()
    eventually(lambda: len(told[-1]) == 1, 5.0)
    assert told[-1] < links
    theirs.close()
    eventually(lambda: not told[-1], 5.0)


def test_a_link_that_was_made_again_is_another_one(nodes: tuple[Node, Node]) -> None:
    """Also when the master's list lacked its publisher for a moment: what was published then was missed."""
    a, b = nodes
    a.publisher("/again", UInt32)
    told: list[frozenset[ConnectedLink]] = []
    subscriber = b.subscriber("/again", UInt32, on_links=told.append)
    subscriber.wait_for_connection(20)
    (before,) = told[-1]
    slave = ServerProxy(b.uri)
    for uris in ([], [a.uri]):
        slave.publisherUpdate("/master", "/again", uris)
    eventually(lambda: len(told[-1]) == 1 and before not in told[-1], 5.0)
    (now,) = told[-1]
    assert (now.node, now.address) == (before.node, before.address)


def test_a_lost_link_is_told_before_its_error(nodes: tuple[Node, Node]) -> None:
    """Whoever hears of the error and asks does not take old values for present ones."""
    a, b = nodes
    a.publisher("/gone", UInt32)
    told: list[frozenset[ConnectedLink]] = []
    at_error: list[int] = []
    subscriber = b.subscriber(
        "/gone", UInt32, on_links=told.append, on_error=lambda _: at_error.append(len(told[-1]))
    )
    subscriber.wait_for_connection(20)
    a.close()
    eventually(lambda: not told[-1], 5.0)
    assert set(at_error) <= {0}


def test_a_link_is_told_before_its_first_message_and_a_failure_of_the_callback_is_logged(
    nodes: tuple[Node, Node], caplog: pytest.LogCaptureFixture
) -> None:
    a, b = nodes
    order: list[object] = []

    def note(links: frozenset[ConnectedLink]) -> None:
        order.append(len(links))
        raise ValueError("a fault of the program")

    a.publisher("/first", UInt32, latch=True).publish(data=7)
    b.subscriber("/first", UInt32, on_links=note, callback=lambda message: order.append("message"))
    eventually(lambda: "message" in order, 5.0)
    assert order == [0, 1, "message"]
    assert "a fault of the program" in caplog.text


def test_a_silent_publisher_that_is_taken_off_the_list_keeps_no_thread(
    nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It accepted the connection, and does not say where its topic is."""
    monkeypatch.setattr(tcpros_link, "TRY_SECONDS", 600.0)
    node = nodes[1]
    master = ServerProxy(node.master_uri)
    with socket.create_server(("127.0.0.1", 0)) as server:
        uri = f"http://127.0.0.1:{server.getsockname()[1]}/"
        master.registerPublisher("/silent", "/mute", UInt32, uri)
        node.subscriber("/mute", UInt32)
        server.settimeout(20)
        with server.accept()[0] as asked:
            asked.settimeout(20)
            assert asked.recv(1)
            thread = f"rosproto:/mute < {uri}"
            assert thread in {each.name for each in threading.enumerate()}
            master.unregisterPublisher("/silent", "/mute", uri)
            eventually(lambda: thread not in {each.name for each in threading.enumerate()}, 20.0)
