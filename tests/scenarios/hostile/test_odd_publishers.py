"""What a subscriber makes of publishers that misbehave; beside each there is a good one of the same topic."""

from __future__ import annotations

import socket
import struct
import time
import tracemalloc
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rosproto.errors import (
    CodecError,
    ConnectionLost,
    Md5sumMismatch,
    RemoteProtocolError,
    RosError,
    TooLarge,
)
from rosproto.master import Master
from rosproto.node import Node, Subscriber
from rosproto.node.incoming import publisher_link_state
from rosproto.protocol.handshake import encode_header
from rosproto.protocol.wire_limits import Limits
from tests.support import attacks
from tests.support.load import crowd
from tests.support.odd_publisher import OddPublisher, good_header, message
from tests.support.victim import eventually

STRING = "std_msgs/String"
MIB = 1 << 20


@pytest.fixture(scope="module")
def master() -> Iterator[Master]:
    with Master() as master:
        yield master


@pytest.fixture
def good(master: Master) -> Iterator[Node]:
    """A node that publishes /t as it should be."""
    with Node("/good", master_uri=master.uri, rosout=False) as node:
        yield node


@pytest.fixture
def hearer(master: Master) -> Iterator[Node]:
    """The node under attack."""
    limits = Limits(handshake_seconds=1.0, message_bytes=1_000_000)
    with Node("/hearer", master_uri=master.uri, limits=limits, rosout=False, intraprocess=False) as node:
        yield node


def then_wait(*parts: bytes) -> Callable[[socket.socket, OddPublisher], None]:
    """A script: read the header, send the parts, keep the connection."""

    def script(sock: socket.socket, odd: OddPublisher) -> None:
        attacks.read_header(sock)
        for part in parts:
            sock.sendall(part)
        odd.ended.wait(120)

    return script


def then_close(*parts: bytes, rst: bool = False) -> Callable[[socket.socket, OddPublisher], None]:
    def script(sock: socket.socket, odd: OddPublisher) -> None:
        attacks.read_header(sock)
        for part in parts:
            sock.sendall(part)
        if rst:
            attacks.reset(sock)

    return script


def drip(data: bytes) -> Callable[[socket.socket, OddPublisher], None]:
    def script(sock: socket.socket, odd: OddPublisher) -> None:
        attacks.read_header(sock)
        for number in range(len(data)):
            sock.sendall(data[number : number + 1])
            if odd.ended.wait(0.02):
                return

    return script


def flood(sock: socket.socket, odd: OddPublisher) -> None:
    attacks.read_header(sock)
    sock.sendall(good_header())
    burst = message("flood") * 1000
    while not odd.ended.is_set():
        sock.sendall(burst)


ODD: dict[str, tuple[Any, type[Exception]]] = {
    "never answers the header": (lambda sock, odd: odd.ended.wait(120), RosError),
    "closes at once": (lambda sock, odd: None, ConnectionLost),
    "resets at once": (lambda sock, odd: attacks.reset(sock), RosError),
    "answers garbage": (then_wait(b"HTTP/1.1 400 Bad Request\r\n\r\n" * 20), RosError),
    "header length 0": (then_wait(bytes(4)), RosError),
    "header length 0xFFFFFFFF": (then_wait(b"\xff" * 4, b"x" * 10_000), RosError),
    "half a header": (then_wait(good_header()[:40]), RosError),
    "closes in its header": (then_close(good_header()[:40]), ConnectionLost),
    "a header that drips": (drip(good_header()), RosError),
    "only an error": (then_wait(encode_header({"error": "nobody is allowed in here"})), RemoteProtocolError),
    "no md5sum": (then_wait(good_header(md5sum="")), RemoteProtocolError),
    "another md5sum": (then_wait(good_header(md5sum="0" * 32)), Md5sumMismatch),
    "message length 0xFFFFFFFF": (then_wait(good_header(), b"\xff" * 4 + b"x" * 1000), TooLarge),
    "message length above the limit": (
        then_wait(good_header(), struct.pack("<I", 1_000_001) + b"x" * 99),
        TooLarge,
    ),
    "closes in a message": (
        then_close(good_header(), message("whole"), message("cut off")[:9]),
        ConnectionLost,
    ),
    "resets in a message": (then_close(good_header(), message("cut off")[:9], rst=True), RosError),
    "a string longer than the message": (
        then_wait(good_header(), struct.pack("<II", 4, 0xFFFFFFF0)),
        CodecError,
    ),
    "bytes behind the message": (then_wait(good_header(), struct.pack("<II", 9, 0) + b"extra"), CodecError),
    "a message of nothing": (then_wait(good_header(), bytes(4)), CodecError),
}


def works_beside(publisher: Any, subscriber: Subscriber) -> None:
    """Ten messages of the good publisher arrive, each at once."""
    for number in range(10):
        publisher.publish(data=f"good {number}")
        while not (got := subscriber.next(60).data).startswith("good"):
            pass
        assert got == f"good {number}"


@pytest.mark.promise("gives a value or a documented error on *that one* connection")
@pytest.mark.parametrize(
    "kind",
    # One of another type is asked again after half a minute, or when the master says that something changed.
    ODD,
)
def test_a_bad_publisher_costs_its_own_link_and_is_taken_back_when_it_is_good(
    kind: str, master: Master, good: Node, hearer: Node, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A documented error says what was wrong; the good publisher is heard all the time; no thread or try runs wild."""
    monkeypatch.setattr(publisher_link_state, "MISMATCH", (2.0, 2.0))  # not half a minute: see its unit tests
    script, error = ODD[kind]
    with OddPublisher(master.uri, script) as odd:
        publisher = good.publisher("/t", STRING)
        subscriber = hearer.subscriber("/t", STRING, queue_size=1000)
        publisher.wait_for_connection(60)
        began = time.monotonic()
        works_beside(publisher, subscriber)
        eventually(lambda: any(isinstance(e, error) for e in subscriber.errors), what=f"{error.__name__}")
        works_beside(publisher, subscriber)
        took = time.monotonic() - began
        assert odd.connections <= 4 + 12 * took, "it is tried again without a pause"
        odd.script = then_wait(good_header(), message("mended"))
        eventually(lambda: subscriber.connections == 2, what="the mended publisher's connection")
        if kind == "only an error":
            assert "nobody is allowed in here" in " ".join(map(str, subscriber.errors))


def test_a_publisher_that_floods_delays_no_other(master: Master, good: Node, hearer: Node) -> None:
    """Its messages fill the queue, the oldest are dropped, whoever sent them; nobody's connection waits for that."""
    with OddPublisher(master.uri, flood):
        publisher = good.publisher("/t", STRING)
        heard: list[str] = []
        hearer.subscriber(
            "/t", STRING, lambda m: heard.append(m.data) if m.data != "flood" else None, queue_size=10
        )
        publisher.wait_for_connection(60)
        mixed = hearer._parts.topics.subscription("/t")
        assert mixed is not None
        other = hearer.subscriber("/other", STRING)
        quiet = good.publisher("/other", STRING)
        quiet.wait_for_connection(60)
        for number in range(20):
            publisher.publish(data=f"good {number}")
            quiet.publish(data="quiet")
            assert other.next(60).data == "quiet"
        received = lambda: sum(link.messages for link in mixed.stats() if link.peer == "/good")  # noqa: E731
        eventually(lambda: received() == 20, what="the good publisher's last message")
        # Which of them the callback gets is chance, but some it does.
        eventually(lambda: heard or publisher.publish(data="good again"), what="one of them")


@pytest.mark.promise("One segment may carry the rest of a")
def test_header_and_messages_in_one_piece(master: Master, hearer: Node) -> None:
    """12: the reply's header and the first messages share a segment; nothing is lost."""
    whole = good_header() + b"".join(message(str(n)) for n in range(100))
    with OddPublisher(master.uri, then_wait(whole), topic="/one", name="/one_piece"):
        subscriber = hearer.subscriber("/one", STRING, queue_size=1000)
        assert [subscriber.next(60).data for _ in range(100)] == [str(n) for n in range(100)]


@pytest.mark.promise("`requestTopic` may offer several protocols, and unknown ones")
@pytest.mark.parametrize("answer", [[], 0, "", "no", {}, ["TCPROS"], ["TCPROS", "127.0.0.1"], ["TCPROS", 5, "x"],
                                    ["TCPROS", "127.0.0.1", 0], ["TCPROS", "127.0.0.1", 99999], ["TCPROS", "", 80],
                                    ["UDPROS", "127.0.0.1", 5, 1, 1500, b"x"], ["TCPROS", "no.such.host.invalid", 80]],
                         ids=range(13))  # fmt: skip
@pytest.mark.parametrize("code", [1, 0])
def test_answers_to_request_topic(code: int, answer: Any, master: Master, hearer: Node) -> None:
    """26: whatever a publisher says instead of an address, it is asked again later, and connected when it is right."""
    with OddPublisher(
        master.uri, then_wait(good_header(), message("late")), topic="/asked", name="/asked_one"
    ) as odd:
        odd.answer, odd.code = answer, code
        with hearer.subscriber("/asked", STRING) as subscriber:
            eventually(lambda: subscriber.errors, what="an error")
            assert isinstance(subscriber.errors[0], RosError)
            odd.answer = None
            assert subscriber.next(60).data == "late"


def test_definitions_that_are_bombs(master: Master, good: Node, hearer: Node) -> None:
    """A subscriber without a type takes the publisher's own definition: within bounds, or not at all."""
    texts = [
        "uint8[4294967295] a\n", "bool[100000000] a\n", "A a\n" + "=" * 80 + "\nMSG: x/A\nx/A a\n", "x" * 900_000,
        "\n".join(f"int32 f{n}" for n in range(50_000)),
        "L1 a\nL1 b\n" + "".join(f"{'=' * 80}\nMSG: x/L{n}\nL{n + 1}[100] a\nL{n + 1}[100] b\n" for n in range(1, 40))
        + "=" * 80 + "\nMSG: x/L40\nuint8 a\n",
    ]  # fmt: skip
    for number, text in enumerate(texts):
        header = good_header(type="x/T", md5sum="ab" * 16, message_definition=text)
        with OddPublisher(master.uri, then_wait(header), topic=f"/bomb{number}", name=f"/bomber{number}"):
            tracemalloc.start()
            try:
                began = time.process_time()
                with hearer.subscriber(f"/bomb{number}") as subscriber:
                    eventually(lambda s=subscriber: s.errors, what=f"the refusal of definition {number}")  # type: ignore[misc]
                    assert isinstance(subscriber.errors[0], (RosError, ValueError))
                assert time.process_time() - began < 2.0, "it was read to the end"
                assert tracemalloc.get_traced_memory()[1] < 64 * MIB
            finally:
                tracemalloc.stop()


def test_element_counts_that_are_bombs(master: Master, hearer: Node) -> None:
    """57: four billion elements without a byte, strings within arrays: an error, no memory."""
    definition = "Nothing[] a\n" + "=" * 80 + "\nMSG: x/Nothing\n"
    from rosproto.codec import define

    cls: Any = define("x/Nothings", definition)
    header = good_header(type="x/Nothings", md5sum=cls._md5sum, message_definition=definition)
    bomb = struct.pack("<II", 4, 0xFFFFFFFF)
    with OddPublisher(master.uri, then_wait(header, bomb), topic="/count", name="/counter"):
        tracemalloc.start()
        try:
            with hearer.subscriber("/count") as subscriber:
                eventually(lambda: subscriber.errors)
                assert isinstance(subscriber.errors[0], CodecError)
            assert tracemalloc.get_traced_memory()[1] < 64 * MIB
        finally:
            tracemalloc.stop()


@pytest.mark.promise("`message_definition` is the full text with all dependencies")
@pytest.mark.parametrize("divider", ["=" * 80, "=" * 3, "=" * 79, "=" * 200])
def test_dividers_in_a_definition(divider: str, master: Master, hearer: Node) -> None:
    """6: any run of three or more "=" divides the texts."""
    from rosproto.codec import define

    definition = f"Inner i\n{divider}\nMSG: y/Inner\nstring data\n"
    cls: Any = define("y/Outer", definition)
    header = good_header(type="y/Outer", md5sum=cls._md5sum, message_definition=definition)
    with (
        OddPublisher(master.uri, then_wait(header, message("inside")), topic="/divided", name="/divider"),
        hearer.subscriber("/divided") as subscriber,
    ):
        assert subscriber.next(60).i.data == "inside"


@pytest.mark.promise("A peer that is restarted on the same")
def test_the_own_uri_and_a_restart_on_the_same_one(master: Master, hearer: Node) -> None:
    """28, 29: a node hears itself once; a publisher that comes back under its old URI is found by its dead link."""
    own = hearer.publisher("/self", STRING)
    subscriber = hearer.subscriber("/self", STRING, queue_size=10)
    own.wait_for_connection(60)
    own.publish(data="me")
    assert subscriber.next(60).data == "me"
    assert subscriber.connections == 1
    with OddPublisher(
        master.uri, then_wait(good_header(), message("first")), topic="/again", name="/back"
    ) as first:
        port = int(first.uri.rstrip("/").rpartition(":")[2])
        again = hearer.subscriber("/again", STRING)
        assert again.next(60).data == "first"
        first._master.close()  # it dies without a word to the master
        first.ended.set()
        first._server.close()
        first._slave.close()
        eventually(lambda: again.connections == 0)
        with OddPublisher(
            master.uri, then_wait(good_header(), message("second")), topic="/again", name="/back", port=port
        ):
            began = time.monotonic()
            assert again.next(60).data == "second"
            assert time.monotonic() - began < 2 * crowd()
        first._master = type(first._master)(master.uri, "/back")
