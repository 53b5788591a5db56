"""What a peer makes a node remember, do and say is bounded, however often it comes back."""

from __future__ import annotations

import gc
import logging
import socket
import threading
import time
import tracemalloc
import weakref
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto.codec import classes, define, message_class
from rosproto.errors import ConnectionLost
from rosproto.master import Master
from rosproto.msg import DefinitionLibrary
from rosproto.node import Node
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.graph.slave_client import NodeClient
from rosproto.node.incoming.delivery import RevisedDelivery
from rosproto.node.outgoing.publication import Publication
from rosproto.protocol.handshake import encode_header, subscriber_header
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import read_header
from tests.support import attacks
from tests.support.odd_publisher import OddPublisher, good_header
from tests.support.victim import eventually

String = message_class("std_msgs/String")


@pytest.fixture
def node() -> Iterator[Node]:
    with Master() as master, Node("/victim", master_uri=master.uri, rosout=False) as node:
        yield node


def revised(number: int, padding: int = 0) -> tuple[str, str]:
    """A definition of std_msgs/String of somebody's own, and its md5sum."""
    text = f"string data\nint32 added_{number}\n" + "".join(f"# {i:060}\n" for i in range(padding // 63))
    return text, define("std_msgs/String", text)._md5sum


def shake_hands(
    node: Node, text: str, md5sum: str, topic: str = "/t"
) -> tuple[socket.socket, dict[str, str]]:
    """Subscribe with a definition of one's own: the connection, and the answer."""
    sock = socket.create_connection(node.tcpros_address, 20)
    fields = subscriber_header(
        topic=topic, type_name="std_msgs/String", md5sum=md5sum, callerid="/stranger", message_definition=text
    )
    sock.sendall(encode_header(fields))
    return sock, read_header(sock, Limits(), Deadline(20))


@pytest.fixture
def narrow() -> Iterator[Node]:
    """A node that takes one definition of strangers at a time."""
    limits = Limits(revisions=1)
    with Master() as master, Node("/victim", master_uri=master.uri, rosout=False, limits=limits) as node:
        yield node


def takes_another(node: Node) -> bool:
    """Whether a node has room for the definition of one more stranger, who leaves at once."""
    sock, answer = shake_hands(node, *revised(9))
    sock.close()
    return "error" not in answer


@pytest.mark.promise("a definition that a peer sends is dropped with its connection")
def test_a_revision_goes_with_its_last_subscriber(narrow: Node) -> None:
    """Its last subscriber ends it; the others get what they got."""
    node = narrow
    publisher = node.publisher("/t", String)
    text, md5sum = revised(1)
    first, answer = shake_hands(node, text, md5sum)
    second, _ = shake_hands(node, text, md5sum)
    assert answer["md5sum"] == md5sum
    eventually(lambda: publisher.connections == 2)
    publisher.publish(data="x")
    assert first.recv(100) == (9).to_bytes(4, "little") + (1).to_bytes(4, "little") + b"x" + bytes(4)
    first.close()
    eventually(lambda: publisher.connections == 1)
    assert not takes_another(node)
    second.close()
    eventually(lambda: takes_another(node))


@pytest.mark.promise("a definition that a peer sends is dropped with its connection")
def test_one_that_leaves_during_the_handshake_leaves_nothing(
    narrow: Node, monkeypatch: pytest.MonkeyPatch
) -> None:
    left, output_for = [], Publication.output_for

    def then_gone(publication: Publication, *given: Any) -> Any:
        left.append(output_for(publication, *given))
        raise ConnectionLost("the subscriber has left")

    narrow.publisher("/t", String)
    with monkeypatch.context() as patched:
        patched.setattr(Publication, "output_for", then_gone)
        with pytest.raises(ConnectionLost):
            shake_hands(narrow, *revised(2))
    assert left[0] is not None
    assert takes_another(narrow)


def test_the_revisions_of_one_topic_are_counted() -> None:
    """One more than allowed is refused with the name of the limit; the others are served."""
    limits = Limits(revisions=2)
    with Master() as master, Node("/victim", master_uri=master.uri, rosout=False, limits=limits) as node:
        publisher = node.publisher("/t", String)
        connected = [shake_hands(node, *revised(number))[0] for number in range(2)]
        eventually(lambda: publisher.connections == 2)
        refused, answer = shake_hands(node, *revised(3))
        assert "revisions: 3 announced, at most 2 allowed" in answer["error"]
        again, answer = shake_hands(node, *revised(1))
        assert "error" not in answer
        for sock in (*connected, refused, again):
            sock.close()


@pytest.mark.promise("a definition that a peer sends is dropped with its connection")
@pytest.mark.slow
def test_many_subscribers_with_definitions_of_their_own_take_no_memory(node: Node) -> None:
    """300 of 50 kB that come and go: it was 274 MB of large ones, and each made `publish` slower."""
    publisher = node.publisher("/t", String)
    tracemalloc.start()
    try:
        for number in range(300):
            text, md5sum = revised(number, 50_000)
            sock, answer = shake_hands(node, text, md5sum)
            assert "error" not in answer
            sock.close()
            if number == 99:
                before = tracemalloc.get_traced_memory()[0]
        eventually(lambda: publisher.connections == 0)
        gc.collect()
        assert tracemalloc.get_traced_memory()[0] - before < 1_000_000
        assert tracemalloc.get_traced_memory()[1] < 60_000_000  # as it was after the first hundred
    finally:
        tracemalloc.stop()


@pytest.mark.promise("is bounded in number and length")
@pytest.mark.slow
def test_what_peers_define_is_kept_by_its_length() -> None:
    """A few long texts are as much as many short ones."""
    made: list[tuple[weakref.ref[type], int]] = []
    for number in range(50):
        text = revised(number)[0] + "# " + "x" * 500_000
        made.append((weakref.ref(define("std_msgs/String", text)), len(text)))
    gc.collect()
    assert 1_000_000 < sum(length for cls, length in made if cls() is not None) <= 2 << 20


@pytest.mark.promise("is bounded in number and length")
def test_what_was_looked_for_in_vain_is_kept_by_number(monkeypatch: pytest.MonkeyPatch) -> None:
    """An md5sum is a stranger's text: those that are none are not even looked for."""
    searches, has = [0], DefinitionLibrary.has

    def counted(library: DefinitionLibrary, *given: Any) -> bool:
        searches[0] += 1
        return has(library, *given)

    monkeypatch.setattr(DefinitionLibrary, "has", counted)
    revisions = KnownDefinitions()

    def looks(md5sum: str) -> bool:
        before = searches[0]
        assert revisions.message(String, md5sum) is None
        return searches[0] > before

    for number in range(1500):
        assert looks(f"{number:032x}")
        assert not looks("f" * 10_000 + str(number))
    assert [looks(f"{number:032x}") for number in reversed(range(1500))] == [False] * 1000 + [True] * 500


def test_a_publisher_of_another_revision_that_comes_back_leaves_nothing(node: Node) -> None:
    """Each session has its own way of decoding, and takes it along when it ends."""
    text, md5sum = revised(4)

    def come_and_go(sock: socket.socket, odd: OddPublisher) -> None:
        read_header(sock, Limits(), Deadline(20))
        sock.sendall(good_header(md5sum=md5sum, message_definition=text))
        sock.sendall((13).to_bytes(4, "little") + (5).to_bytes(4, "little") + b"hello" + bytes(4))

    def deliveries() -> int:
        gc.collect()
        return sum(type(each) is RevisedDelivery for each in gc.get_objects())

    with OddPublisher(node.master_uri, come_and_go) as odd, node.subscriber("/t", String) as subscriber:
        eventually(lambda: odd.connections >= 5 and subscriber.received >= 4)
        eventually(lambda: deliveries() <= 1)


@pytest.mark.promise("retried every few seconds")
def test_a_publisher_that_agrees_and_leaves_is_not_told_of_every_time(
    node: Node, caplog: pytest.LogCaptureFixture
) -> None:
    """Names and definitions are its own, a megabyte each; the log stays short, and the tries get rarer."""
    text, md5sum = revised(5)
    seen: list[float] = []

    def agree_and_leave(sock: socket.socket, odd: OddPublisher) -> None:
        read_header(sock, Limits(), Deadline(20))
        seen.append(time.monotonic())
        sock.sendall(good_header(md5sum=md5sum, message_definition=text, callerid="/" + "x" * 900_000))

    with caplog.at_level(logging.INFO), OddPublisher(node.master_uri, agree_and_leave):
        with node.subscriber("/t", String):
            eventually(lambda: len(seen) >= 9)
        assert seen[8] - seen[0] > 0.8 * (
            0.05 + 0.1 + 0.2 + 0.4
        )  # two connections each time, for both definitions
    assert sum(len(text) for text in caplog.messages) < 100_000


@pytest.mark.promise("every few minutes")
def test_a_publisher_of_another_type_is_asked_once(node: Node, caplog: pytest.LogCaptureFixture) -> None:
    """Waiting cures no definition: it is told once, and tried again when the master names it again."""
    asked = threading.Semaphore(0)

    def refuse(sock: socket.socket, odd: OddPublisher) -> None:
        header = attacks.read_header(sock)
        asked.release()
        number = classes.message_class("std_msgs/Int32")
        if header["md5sum"] != "*":
            text = f"md5sums do not match: {header['md5sum']} vs. {number._md5sum}"
            sock.sendall(encode_header({"error": text}))
        else:
            sock.sendall(
                good_header(type="std_msgs/Int32", md5sum=number._md5sum, message_definition="int32 data\n")
            )

    with OddPublisher(node.master_uri, refuse) as odd, node.subscriber("/t", String) as subscriber:
        assert asked.acquire(timeout=20)
        assert asked.acquire(timeout=20)  # for its own definition, to show both
        eventually(lambda: subscriber.errors)
        assert not asked.acquire(timeout=1.5)
        with NodeClient(node.uri, "/master") as told:
            told.publisher_update("/t", [odd.uri])
        assert asked.acquire(timeout=20)
    assert len([text for text in caplog.messages if "std_msgs/Int32" in text]) == 1


@pytest.mark.promise("is bounded in number and length")
def test_the_name_of_a_subscriber_is_cut(node: Node) -> None:
    """It is kept for as long as the connection lasts, and there may be thousands."""
    publisher = node.publisher("/t", String)
    sock = socket.create_connection(node.tcpros_address, 20)
    fields = subscriber_header(
        topic="/t", type_name="std_msgs/String", md5sum=String._md5sum, callerid="/" + "n" * 500_000
    )
    sock.sendall(encode_header(fields))
    eventually(lambda: publisher.connections == 1)
    assert len(publisher.subscribers[0]) == 1024
    sock.close()
