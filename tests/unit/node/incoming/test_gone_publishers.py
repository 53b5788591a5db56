"""Publishers that have ended and did not unregister: they cost no thread, are tried ever less, and come back at once."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterable, Iterator

import pytest

from rosproto.master import Master
from rosproto.node import MasterClient, Node, Subscriber
from rosproto.node.graph.registrations import Registration, Registrations
from rosproto.node.incoming import publisher_link_state
from rosproto.node.incoming.subscription import Subscription
from rosproto.transport import shared_threads
from tests.support.load import crowd
from tests.support.ros import free_port
from tests.support.waiting import until

STRING = "std_msgs/String"


@pytest.fixture
def dead() -> Iterator[int]:
    """A port at which nothing listens."""
    with socket.socket() as held:  # bound, so that no other program gets it
        held.bind(("127.0.0.1", 0))
        yield held.getsockname()[1]


@pytest.fixture
def graph() -> Iterator[tuple[Node, MasterClient]]:
    """A node, and the client of its master by which a publisher is registered that does not exist."""
    with (
        Master() as master,
        Node("/here", master_uri=master.uri, rosout=False, intraprocess=False) as node,
        MasterClient(master.uri, "/gone") as client,
    ):
        yield node, client


Graph = tuple[Node, MasterClient]


def link_threads(topic: str) -> int:
    return sum(thread.name.startswith(f"rosproto:{topic}") for thread in threading.enumerate())


def waiting(node: Node) -> Subscriber:
    """A subscriber of /t whose link waits for its next try."""
    subscriber = node.subscriber("/t", STRING)
    until(lambda: subscriber.errors and [link.state for link in node.stats().links] == ["waiting"])
    return subscriber


def test_links_that_wait_have_no_thread(graph: Graph, dead: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """One thread of the process waits for all of them."""
    monkeypatch.setattr(publisher_link_state, "GONE", (30.0, 60.0))
    node, client = graph
    for number in range(50):
        client.register_publisher(f"/gone{number}", STRING, f"http://127.0.0.1:{dead}/")
    subscribers = [node.subscriber(f"/gone{number}", STRING) for number in range(50)]
    until(lambda: all(subscriber.errors for subscriber in subscribers))
    until(lambda: not link_threads("/gone"), what="the end of the links' threads")
    # Those that have just worked end when they have been idle for a moment.
    until(
        lambda: [thread.name for thread in threading.enumerate()].count("rosproto:shared") <= 5,
        what="five shared threads at most",
    )


def test_a_publisher_that_registers_again_is_connected_at_once(
    graph: Graph, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However long the present wait is: the master names it."""
    monkeypatch.setattr(publisher_link_state, "GONE", (600.0, 600.0))
    port = free_port()
    node, client = graph
    client.register_publisher("/t", STRING, f"http://127.0.0.1:{port}/")
    subscriber = node.subscriber("/t", STRING)
    until(lambda: subscriber.errors)
    assert subscriber.connections == 0
    with Node("/back", master_uri=client.uri, port=port, rosout=False) as back:
        back.publisher("/t", STRING)
        subscriber.wait_for_connection(5.0)


def test_asking_the_master_does_not_shorten_the_wait(
    graph: Graph, dead: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A link that asks whether its publisher is still listed would otherwise try for ever at full speed."""
    monkeypatch.setattr(publisher_link_state, "GONE", (0.01, 0.01))
    nudges: list[object] = []
    monkeypatch.setattr(Subscription, "nudge", nudges.append)
    asked = threading.Event()
    announce = Registrations.announce_again

    def noted(self: Registrations, registrations: Iterable[Registration]) -> None:
        some = list(registrations)
        announce(self, some)
        if some:
            asked.set()

    monkeypatch.setattr(Registrations, "announce_again", noted)
    node, client = graph
    client.register_publisher("/t", STRING, f"http://127.0.0.1:{dead}/")
    node.subscriber("/t", STRING)
    assert asked.wait(20)  # by the link, after some tries
    assert not nudges


def test_closing_a_link_that_waits_takes_no_time(
    graph: Graph, dead: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing of it stays."""
    monkeypatch.setattr(publisher_link_state, "GONE", (600.0, 600.0))
    node, client = graph
    client.register_publisher("/t", STRING, f"http://127.0.0.1:{dead}/")
    subscriber = waiting(node)
    began = time.monotonic()
    subscriber.close()
    assert time.monotonic() - began < 2.0 * crowd()
    assert not node.stats().links
    assert not link_threads("/t")


def test_links_are_tried_again_though_no_thread_can_be_started(
    graph: Graph, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process that reaches its limit of threads for a while does not lose its links."""
    refused = threading.Event()

    def refuse(self: threading.Thread) -> None:
        refused.set()
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(publisher_link_state, "GONE", (0.01, 0.01))
    port = free_port()
    node, client = graph
    client.register_publisher("/t", STRING, f"http://127.0.0.1:{port}/")
    subscriber = waiting(node)
    with monkeypatch.context() as patched:
        patched.setattr(threading.Thread, "start", refuse)
        assert refused.wait(5)
    with Node("/back", master_uri=client.uri, port=port, rosout=False) as back:
        back.publisher("/t", STRING)
        subscriber.wait_for_connection(5.0)


def test_one_pool_for_the_process() -> None:
    """Every caller gets the same threads."""
    assert shared_threads.shared_threads() is shared_threads.shared_threads()
