"""How a subscriber that was cut off is brought back; the network part is in tests/scenarios/network."""

from __future__ import annotations

import socket
import sys
import threading
from collections.abc import Iterator

import pytest

from rosproto.errors import ConnectionLost
from rosproto.node.outgoing import reconnect
from rosproto.node.outgoing.reconnect import SubscriberReconnect
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import bind_beside, listen

linux = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nobody binds beside a listening socket")


class Topic:
    """A listening socket; the subscriber is back after the topic was announced so many times."""

    def __init__(self, listener: socket.socket) -> None:
        self.listener = listener
        self.closing = threading.Event()
        self.announced = 0
        self.enough = 1

    def announce(self) -> None:
        self.announced += 1
        if self.announced == 1 < self.enough:
            raise ConnectionLost("the master is away", peer="")

    def lost(self, remote: tuple[str, int]) -> SubscriberReconnect:
        return SubscriberReconnect(
            self.closing,
            "/s",
            bind=lambda sock: bind_beside(sock, self.listener, self.listener.getsockname()),
            remote=remote,
            announce=self.announce,
            is_back=lambda: self.announced >= self.enough,
        )


@pytest.fixture
def topic(monkeypatch: pytest.MonkeyPatch) -> Iterator[Topic]:
    monkeypatch.setattr(reconnect, "SETTLE_SECONDS", 0.0)
    with listen("127.0.0.1") as listener:
        yield Topic(listener)


@pytest.fixture
def nobody() -> tuple[str, int]:
    """An address at which nobody listens."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return "127.0.0.1", server.getsockname()[1]


@linux
def test_who_refuses_has_no_half_of_the_connection_left(topic: Topic, nobody: tuple[str, int]) -> None:
    assert topic.lost(nobody).knock()


@linux
def test_a_living_connection_is_not_knocked_at(topic: Topic) -> None:
    """Our own half is still there: there is nothing to find out yet, and nothing is harmed."""
    with socket.create_connection(topic.listener.getsockname()) as theirs, topic.listener.accept()[0] as ours:
        lost = topic.lost(ours.getpeername())
        topic.closing.set()  # it would wait a second
        assert not lost.knock()
        theirs.sendall(b"x")
        ours.settimeout(20)
        assert ours.recv(1) == b"x"


@linux
def test_nobody_gets_our_port_by_accident(topic: Topic, nobody: tuple[str, int]) -> None:
    """Only a program of the same user that means it could; here, as before, one does not that binds as all do."""
    topic.lost(nobody).knock()
    with socket.socket() as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        with pytest.raises(OSError):
            other.bind(topic.listener.getsockname())


@pytest.mark.promise("The reset may be lost with the rest")
def test_it_is_announced_until_it_is_back(topic: Topic, nobody: tuple[str, int]) -> None:
    """A master that is away for the moment is asked again."""
    topic.enough = 2
    topic.lost(nobody).bring_back(Deadline(20.0))
    assert topic.announced == 2


def test_a_node_that_closes_is_not_kept(topic: Topic, nobody: tuple[str, int]) -> None:
    topic.enough = 10
    topic.closing.set()
    topic.lost(nobody).bring_back(Deadline(20.0))
    assert topic.announced == 0


@pytest.mark.promise("At most 32 such subscribers")
def test_no_more_than_a_few_at_a_time(
    topic: Topic, nobody: tuple[str, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reconnect, "_places", threading.BoundedSemaphore(1))
    before = {thread.ident for thread in threading.enumerate()}
    topic.enough = 10
    for _ in range(3):
        topic.lost(nobody).start()
    new = [thread for thread in threading.enumerate() if thread.ident not in before]
    topic.closing.set()
    assert len(new) == 1
    new[0].join(20)
    assert not new[0].is_alive()
