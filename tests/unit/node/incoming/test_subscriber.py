"""What a subscriber tells of its publishers, and how many messages it keeps."""

from __future__ import annotations

import time
from xmlrpc.client import ServerProxy

from rosproto.node import Node
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


def test_the_links_are_a_value_that_changes_with_each_connection(nodes: tuple[Node, Node]) -> None:
    """One entry for each publisher; the value stays the same object while nothing changes."""
    a, b = nodes
    subscriber = b.subscriber("/linked", UInt32)
    assert subscriber.links == frozenset()
    theirs, ours = a.publisher("/linked", UInt32), b.publisher("/linked", UInt32)
    subscriber.wait_for_connection(20, count=2)
    links = subscriber.links
    assert subscriber.links is links
    assert sorted(name for name, _, _ in links) == sorted([a.name, b.name])
    assert {address for _, address, _ in links} == {link.address for link in subscriber.stats()}
    ours.close()
    eventually(lambda: len(subscriber.links) == 1, 5.0)
    assert subscriber.links < links
    theirs.close()
    eventually(lambda: subscriber.links == frozenset(), 5.0)
    subscriber.close()
    assert subscriber.links == frozenset()


def test_a_link_that_was_made_again_is_another_one(nodes: tuple[Node, Node]) -> None:
    """Also when the master's list lacked its publisher for a moment: what was published then was missed."""
    a, b = nodes
    a.publisher("/again", UInt32)
    subscriber = b.subscriber("/again", UInt32)
    subscriber.wait_for_connection(20)
    before = subscriber.links
    slave = ServerProxy(b.uri)
    for uris in ([], [a.uri]):
        slave.publisherUpdate("/master", "/again", uris)
    eventually(lambda: len(subscriber.links) == 1 and subscriber.links.isdisjoint(before), 5.0)
    assert {link[:2] for link in subscriber.links} == {link[:2] for link in before}


def test_a_lost_link_is_gone_before_its_error_is_reported(nodes: tuple[Node, Node]) -> None:
    """Whoever hears of the error and asks does not take old values for present ones."""
    a, b = nodes
    a.publisher("/gone", UInt32)
    told: list[tuple[int, int]] = []
    subscriber = b.subscriber(
        "/gone", UInt32, on_error=lambda _: told.append((len(subscriber.links), subscriber.connections))
    )
    subscriber.wait_for_connection(20)
    a.close()
    eventually(lambda: bool(told) or not subscriber.links, 5.0)
    assert set(told) <= {(0, 0)}
    assert subscriber.links == frozenset()
