"""What a publisher is told of its subscribers, and what it says to them."""

from __future__ import annotations

import logging
import signal
import threading
from typing import Any

import pytest

from rosproto import Master
from rosproto.node import Node
from rosproto.node.events import Event, EventKind, Events
from rosproto.node.outgoing.publication import Publication
from tests.support.victim import eventually

String = "std_msgs/String"


def test_subscribers_that_come_and_go_are_told(nodes: tuple[Node, Node]) -> None:
    """By name; a closed publisher is told nothing more."""
    a, b = nodes
    came: list[str] = []
    left: list[str] = []
    with a.publisher("/told", String, on_connect=came.append, on_disconnect=left.append):
        with b.subscriber("/told", String):
            eventually(lambda: came)
            assert not left
        eventually(lambda: left)
    with a.publisher("/told", String, latch=True) as publisher, b.subscriber("/told", String) as subscriber:
        publisher.publish(data="x")
        subscriber.next(5)
    eventually(lambda: not publisher.connections)
    assert came == left == [b.name]


def test_a_publisher_adds_to_the_header(nodes: tuple[Node, Node]) -> None:
    """Asked for each subscriber; what has a meaning of its own is replaced."""
    a, b = nodes
    with a.publisher("/more", String, latch=True, header=lambda: {"who": "me", "type": "*"}) as publisher:
        publisher.publish(data="x")
        with b.subscriber("/more", String) as subscriber:
            header = subscriber.next(5)._connection_header
    assert (header["who"], header["type"], header["topic"]) == ("me", "*", "/more")


def test_what_a_callback_raises_ends_no_link(
    nodes: tuple[Node, Node], caplog: pytest.LogCaptureFixture
) -> None:
    """It is logged."""
    a, b = nodes

    def broken(*_: object) -> dict[str, str]:
        raise RuntimeError("broken callback")

    options = {"on_connect": broken, "on_disconnect": broken, "header": broken}
    with caplog.at_level(logging.ERROR), a.publisher("/broken", String, latch=True, **options) as publisher:
        publisher.publish(data="x")
        with b.subscriber("/broken", String) as subscriber:
            assert subscriber.next(5).data == "x"
        eventually(lambda: len([one for one in caplog.records if one.exc_info]) == 3)


def test_a_ctrl_c_that_arrives_in_a_callback_is_not_lost(caplog: pytest.LogCaptureFixture) -> None:
    """A subscriber of this process that closes has the publisher's callback called in the main thread."""
    heard: list[object] = []

    def interrupted(who: object) -> None:
        heard.append(who)
        if threading.current_thread() is threading.main_thread():
            signal.raise_signal(signal.SIGINT)

    with (
        Master() as master,
        Node("/a", master_uri=master.uri, rosout=False) as a,
        Node("/b", master_uri=master.uri, rosout=False) as b,
        a.publisher("/t", String, latch=True, on_disconnect=interrupted) as publisher,
    ):
        subscriber = b.subscriber("/t", String)
        publisher.publish(data="x")
        subscriber.next(5)
        with pytest.raises(KeyboardInterrupt):
            subscriber.close()
        eventually(lambda: not publisher.connections)
    assert heard == [b.name]
    assert not [one for one in caplog.records if one.exc_info]


def test_who_closes_a_subscriber_of_this_process_is_who_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not the subscriber's own thread, even when the one that closes is slow."""
    heard: list[str] = []
    other = threading.Event()

    def told(_: object) -> None:
        heard.append(threading.current_thread().name)

    with (
        Master() as master,
        Node("/a", master_uri=master.uri, rosout=False) as a,
        Node("/b", master_uri=master.uri, rosout=False) as b,
        a.publisher("/slowly", String, latch=True, on_disconnect=told) as publisher,
    ):
        subscriber = b.subscriber("/slowly", String)
        publisher.publish(data="x")
        subscriber.next(5)
        detach = Publication.detach

        def slow(publication: Publication, link: Any) -> None:
            if threading.current_thread() is threading.main_thread():
                other.wait(0.1)
            else:
                other.set()
            detach(publication, link)

        monkeypatch.setattr(Publication, "detach", slow)
        subscriber.close()
    assert heard == [threading.main_thread().name]


def test_a_ctrl_c_that_arrives_in_on_event_is_not_lost(caplog: pytest.LogCaptureFixture) -> None:
    """In the main thread it ends the program; what another thread raises is the callback's own, and logged."""

    def interrupted(_: object) -> None:
        raise KeyboardInterrupt

    events = Events("/n", interrupted)
    with pytest.raises(KeyboardInterrupt):
        events.emit(Event(EventKind.CONNECTED))
    assert not caplog.records
    thread = threading.Thread(target=events.emit, args=(Event(EventKind.CONNECTED),))
    thread.start()
    thread.join(5)
    assert [one.message for one in caplog.records] == ["! /n: on_event raised"]
    assert len(list(events)) == 2
