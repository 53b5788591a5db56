"""Between a publisher's header and its link there is no gap: who has read the header misses nothing.

The message in that gap may be the zero that ends a drive.
"""

from __future__ import annotations

import select
import socket
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto.master import Master
from rosproto.node import Node
from rosproto.node.outgoing.publication import Publication
from tests.support import attacks

SUBSCRIBERS = 50


@pytest.fixture
def node(master: Master) -> Iterator[Node]:
    with Node("/first", master_uri=master.uri, host="127.0.0.1", rosout=False, timeout=20.0) as node:
        yield node


def subscriber(node: Node) -> socket.socket:
    """A connection that has sent its header and read nothing."""
    address = node.tcpros_address
    return attacks.connect(address, attacks.subscriber_header("/numbers"))


def test_nobody_is_told_before_it_is_attached(node: Node, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is published right after the link stands is behind the header, and nothing comes before it."""
    publisher = node.publisher("/numbers", "std_msgs/String", queue_size=1)
    attach, told, looked, connected = Publication.attach, *(threading.Event() for _ in range(3))

    def watched(self: Publication, link: Any, *others: Any) -> None:
        assert connected.wait(20)
        if select.select([sock], [], [], 0.1)[0]:
            told.set()
        looked.set()
        start = link.start
        monkeypatch.setattr(type(link), "start", lambda link: (publisher.publish(data="first"), start())[1])
        attach(self, link, *others)

    monkeypatch.setattr(Publication, "attach", watched)
    with subscriber(node) as sock:
        connected.set()
        sock.settimeout(20)
        assert looked.wait(20)
        assert attacks.read_header(sock)["topic"] == "/numbers"
        assert attacks.read_frame(sock)[4:] == b"first"
    assert not told.is_set()


def test_one_that_has_read_the_header_gets_what_is_published_from_then_on(node: Node) -> None:
    """Fifty subscribers connect while numbers are published as fast as possible."""
    publisher = node.publisher("/numbers", "std_msgs/String", queue_size=100_000)
    published, stop = [0], threading.Event()

    def publish() -> None:
        while not stop.is_set():
            publisher.publish(data=str(published[0] + 1))
            published[0] += 1

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        for _ in range(SUBSCRIBERS):
            with subscriber(node) as sock:
                sock.settimeout(20)
                attacks.read_header(sock)
                done = published[0]
                first = int(attacks.read_frame(sock)[4:])
                assert first <= done + 2  # one may have been under way to the others
    finally:
        stop.set()
        thread.join(20)


def test_the_header_is_no_message_in_the_counters(node: Node) -> None:
    """Neither in their number nor in their bytes, before and after the first message."""
    publisher = node.publisher("/numbers", "std_msgs/String")
    with subscriber(node) as sock:
        sock.settimeout(20)
        attacks.read_header(sock)
        publisher.wait_for_connection(20)
        (before,) = publisher.stats()
        assert (before.messages, before.bytes, before.dropped) == (0, 0, 0)
        publisher.publish(data="abc")
        attacks.read_frame(sock)
        (after,) = publisher.stats()
        assert (after.messages, after.bytes) == (1, 11)
