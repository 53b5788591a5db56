"""Calls to one node: delivered, gone, silent."""

from __future__ import annotations

import socket
import sys
import threading
from collections.abc import Iterator

import pytest

from rosproto.master.notifications import ParamUpdate, PublisherUpdate, Shutdown
from rosproto.master.notifier import DeliveryOutcome
from rosproto.master.slave_calls import NodeSender
from rosproto.protocol.wire_limits import Limits
from tests.support.slaves import BlackHole, RecordingNode


def send(uri: str, timeout: float = 5.0) -> DeliveryOutcome:
    sender = NodeSender(uri, lambda _: ["/n"], timeout=timeout, limits=Limits())
    try:
        return sender.send(PublisherUpdate(uri, "/t", ("http://a:1/",)))
    finally:
        sender.close()


@pytest.fixture
def hangs_up() -> Iterator[str]:
    """URI of a server that closes every connection without an answer."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()

        def accept() -> None:
            while True:
                try:
                    listener.accept()[0].close()
                except OSError:
                    return

        thread = threading.Thread(target=accept, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{listener.getsockname()[1]}/"
        if sys.platform == "win32":
            listener.close()  # wakes accept there; shutting down a listening socket is an error
        else:
            listener.shutdown(socket.SHUT_RDWR)
        thread.join(20)


def test_an_answer_of_any_kind_is_a_delivery() -> None:
    """Also a fault: the node knows, and its opinion does not matter."""
    with RecordingNode() as node:
        assert send(node.uri) is DeliveryOutcome.DONE
        assert node.calls == [("publisherUpdate", ["/t", ["http://a:1/"]])]
        sender = NodeSender(node.uri, lambda _: ["/n"], timeout=5.0, limits=Limits())
        assert sender.send(ParamUpdate(node.uri, "/k/", {"a": 1})) is DeliveryOutcome.DONE
        sender.close()
        sender = NodeSender(node.uri, lambda _: [], timeout=5.0, limits=Limits())
        # getName is a fault of this node, its lists are empty: asked, and left alone.
        note = Shutdown(node.uri, "/n", "why", frozenset({"/t"}), frozenset())
        assert sender.send(note) is DeliveryOutcome.DONE
        assert node.told("shutdown") == []
        sender.close()


def test_nobody_registered_there_gets_nothing() -> None:
    """A retry must not tell a stranger, who has the port now, about topics it never asked for."""
    with RecordingNode() as node:
        sender = NodeSender(node.uri, lambda _: [], timeout=5.0, limits=Limits())
        assert sender.send(PublisherUpdate(node.uri, "/t", ())) is DeliveryOutcome.GONE
        assert node.calls == []
        sender.close()


def test_only_a_refused_connection_means_gone() -> None:
    """The node's socket is closed: the node has ended."""
    with RecordingNode() as node:
        pass
    assert send(node.uri) is DeliveryOutcome.GONE


@pytest.mark.parametrize("uri", ["http://", "rosrpc://[", "http://h:99999/"])
def test_what_is_no_uri_can_be_registered_but_not_called(uri: str) -> None:
    """rosmaster's validation lets it in; nobody can be there."""
    assert send(uri) is DeliveryOutcome.GONE


def test_no_answer_in_time_is_silence() -> None:
    """Tried again later."""
    with BlackHole() as hole:
        assert send(hole.uri, timeout=0.05) is DeliveryOutcome.SILENT


def test_a_broken_connection_is_silence_too(hangs_up: str) -> None:
    """A busy or restarting node must not lose the news for that."""
    assert send(hangs_up) is DeliveryOutcome.SILENT


def test_closing_ends_a_call_that_is_under_way() -> None:
    """So that a master can close in bounded time."""
    with BlackHole() as hole:
        sender = NodeSender(hole.uri, lambda _: ["/n"], timeout=60.0, limits=Limits())
        outcome: list[DeliveryOutcome] = []
        call = threading.Thread(
            target=lambda: outcome.append(sender.send(PublisherUpdate(hole.uri, "/t", ()))), daemon=True
        )
        call.start()
        call.join(0.05)  # most likely inside the call by then; either way it has to end
        sender.close()
        call.join(10.0)
        assert outcome == [DeliveryOutcome.SILENT]
