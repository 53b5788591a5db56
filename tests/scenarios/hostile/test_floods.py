"""Peers that are silent, slow, half open, noisy or many: each costs a bounded amount, and nobody else anything."""

from __future__ import annotations

import random
import socket
import struct
import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from typing import Any

import pytest

from tests.support import attacks
from tests.support.load import crowd
from tests.support.victim import Victim, eventually

Unharmed = Callable[..., AbstractContextManager[None]]
DOORS = ("master", "node", "tcpros")  # XML-RPC, XML-RPC, TCPROS


@pytest.mark.promise("rospy reads the header inside its accept loop")
@pytest.mark.parametrize("door", DOORS)
def test_a_thousand_silent_connections(door: str, victim: Victim, unharmed: Unharmed) -> None:
    """Connected, nothing sent: at most `pending_handshakes` of them are kept, and those end in time."""
    with unharmed(memory=96), attacks.many(getattr(victim, door), 1000):
        key = {"master": "master", "node": "slave", "tcpros": "tcpros"}[door]
        eventually(lambda: victim.ask()[key] <= 20, what="the end of the silent connections")


@pytest.mark.parametrize("door", DOORS)
def test_a_thousand_half_open_connections(door: str, victim: Victim, unharmed: Unharmed) -> None:
    """A request begun and the sending side closed: ended at once, no pile of CLOSE_WAIT (ros_comm#610)."""
    begun = b"POST / HTTP/1.1\r\nContent-le" if door != "tcpros" else struct.pack("<I", 200) + b"topic"
    with unharmed(), attacks.many(getattr(victim, door), 1000, begun) as sockets:
        for sock in sockets:
            try:
                sock.shutdown(socket.SHUT_WR)
            except OSError:
                pass  # it has been dropped already
        key = {"master": "master", "node": "slave", "tcpros": "tcpros"}[door]
        eventually(lambda: victim.ask()[key] <= 20, what="the end of half-open links")


@pytest.mark.parametrize("door", DOORS)
def test_one_byte_at_a_time_buys_no_time(door: str, victim: Victim, unharmed: Unharmed) -> None:
    """Bytes that drip in do not extend the time for a header or a request."""
    data = (
        b"POST / HTTP/1.1\r\n" + b"X-Filler: 0\r\n" * 99
        if door != "tcpros"
        else struct.pack("<I", 999) + b"a" * 999
    )
    with unharmed(), attacks.many(getattr(victim, door), 50) as sockets:
        began = time.monotonic()
        left = list(sockets)
        limit = (Victim.HANDSHAKE_SECONDS + 6) * crowd()
        for number in range(len(data) - 1):
            left = [sock for sock in left if _goes_on(sock, data[number : number + 1])]
            if not left or time.monotonic() - began > limit:
                break
            time.sleep(0.05)
        assert not left, f"{len(left)} connections live after {time.monotonic() - began:.1f} s"


def _goes_on(sock: socket.socket, data: bytes) -> bool:
    try:
        sock.sendall(data)
        sock.setblocking(False)
        return sock.recv(1000) != b""
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        sock.settimeout(60)


@pytest.mark.promise("gives a value or a documented error on *that one* connection")
@pytest.mark.parametrize("door", DOORS)
def test_garbage(door: str, victim: Victim, unharmed: Unharmed) -> None:
    """Three hundred connections with noise, each in another place of a good beginning."""
    noise = random.Random(4)
    good = attacks.http_post(b"<methodCall/>") if door != "tcpros" else attacks.subscriber_header("/tick")
    with unharmed():
        for _ in range(300):
            cut = noise.randrange(len(good))
            data = good[:cut] + noise.randbytes(noise.choice((1, 10, 1000, 20_000)))
            with ExitStack() as stack:
                try:
                    sock = attacks.connect(getattr(victim, door))
                    stack.callback(sock.close)
                    sock.sendall(data)
                except OSError:
                    pass  # ended by the other side before all was sent


@pytest.mark.promise("gives a value or a documented error on *that one* connection")
@pytest.mark.parametrize("door", DOORS)
def test_resets_anywhere(door: str, victim: Victim, unharmed: Unharmed) -> None:
    """Five hundred connections end with RST, before, inside and after a header."""
    good = attacks.http_post(b"<methodCall/>") if door != "tcpros" else attacks.subscriber_header("/tick")
    with unharmed():
        for number in range(500):
            sock = attacks.connect(getattr(victim, door), good[: number % (len(good) + 1)])
            attacks.reset(sock)


@pytest.mark.parametrize("door", DOORS)
def test_two_thousand_that_connect_and_close(door: str, victim: Victim, unharmed: Unharmed) -> None:
    """As port scans and plain probes do (wire.md, fact 8)."""
    with unharmed():
        for _ in range(2000):
            attacks.connect(getattr(victim, door)).close()


def test_a_thousand_requests_pipelined_and_never_read(victim: Victim, unharmed: Unharmed) -> None:
    """Answers nobody reads do not pile up in memory: the sender is ended."""
    body = (
        b"<?xml version='1.0'?><methodCall><methodName>getSystemState</methodName><params><param><value>/a</value>"
        b"</param></params></methodCall>"
    )
    with unharmed(memory=64), ExitStack() as stack:
        for _ in range(5):
            sock = attacks.connect(victim.master)
            stack.callback(sock.close)
            sock.settimeout(2)
            try:
                for _ in range(200):
                    sock.sendall(attacks.http_post(body) * 20)
            except OSError:
                pass  # it does not take any more: as it should be


def test_subscribers_that_never_read(victim: Victim, unharmed: Unharmed) -> None:
    """A hundred subscribers of /tick that read nothing; those that talk without end are cut off."""
    with unharmed(), attacks.many(victim.tcpros, 100, attacks.subscriber_header("/tick")) as sockets:
        for sock in sockets[:10]:
            attacks.read_header(sock)
        for sock in sockets[:10]:
            assert not _takes(sock, 50_000_000)


def _takes(sock: socket.socket, size: int) -> bool:
    """Whether the other side takes so many bytes."""
    try:
        for _ in range(size // 50_000):
            sock.sendall(b"x" * 50_000)
    except OSError:
        return False
    return True


def test_subscribers_that_come_and_go(victim: Victim, unharmed: Unharmed) -> None:
    """Five hundred times, closing in every possible state."""
    header = attacks.subscriber_header("/tick")
    with unharmed():
        for number in range(500):
            sock = attacks.connect(victim.tcpros, header)
            if number % 3 == 0:
                attacks.read_header(sock)
            if number % 2:
                sock.close()
            else:
                attacks.reset(sock)


def test_connections_are_counted_with_their_links(victim: Victim) -> None:
    """`Limits.connections` bounds subscribers too, whose connections outlive their handshake's thread."""
    from rosproto.master import Master
    from rosproto.node import Node
    from rosproto.protocol.wire_limits import Limits

    with Master() as master, Node("/few", master_uri=master.uri, limits=Limits(connections=20)) as node:
        publisher = node.publisher("/t", "std_msgs/String")
        address = ("127.0.0.1", node.tcpros_address[1])
        with attacks.many(address, 15, attacks.subscriber_header("/t")):
            publisher.wait_for_connection(60, 15)
            with attacks.many(address, 30, attacks.subscriber_header("/t")) as more:
                eventually(lambda: sum(attacks.ended_by_peer(sock, 0.01) for sock in more) >= 20)
            assert publisher.connections <= 20
        # The links, and the connections that were refused, which may be counted for a moment longer.
        eventually(
            lambda: publisher.connections == node._parts.context.listening.endpoints.tcpros.connections == 0
        )
        with attacks.many(address, 20, attacks.subscriber_header("/t")):
            publisher.wait_for_connection(60, 20)


def test_latched_topics_forget_subscribers_that_are_gone_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The latched message meets a dead connection before the link is among the others: it must not stay there."""
    from rosproto.master import Master
    from rosproto.node import Node
    from rosproto.node.outgoing import publication

    gone = threading.Event()
    real = publication.encode_header

    def wait_and_encode(*arguments: Any) -> bytes:
        gone.wait(5)
        return real(*arguments)

    monkeypatch.setattr(publication, "encode_header", wait_and_encode)
    with Master() as master, Node("/latched", master_uri=master.uri, rosout=False) as node:
        publisher = node.publisher("/kept", "std_msgs/String", latch=True)
        publisher.publish(data="x")
        address = ("127.0.0.1", node.tcpros_address[1])
        attacks.reset(attacks.connect(address, attacks.subscriber_header("/kept")))
        gone.set()
        for _ in range(100):
            attacks.reset(attacks.connect(address, attacks.subscriber_header("/kept")))
        eventually(lambda: publisher.connections == 0, what="the end of the links")
        with attacks.connect(address, attacks.subscriber_header("/kept")) as sock:
            attacks.read_header(sock)
            assert attacks.read_frame(sock)[4:] == b"x"


def test_a_large_latched_message_reaches_a_slow_subscriber_whole() -> None:
    """It does not fit into the socket, and nothing is published after it that would push it on."""
    import numpy as np

    from rosproto.master import Master
    from rosproto.node import Node

    with Master() as master, Node("/latched", master_uri=master.uri, rosout=False) as node:
        node.publisher("/map", "std_msgs/UInt8MultiArray", latch=True).publish(
            data=np.full(20_000_000, 7, "u1")
        )
        header = attacks.subscriber_header("/map", type="*", md5sum="*")
        for _ in range(3):
            with attacks.connect(("127.0.0.1", node.tcpros_address[1]), header) as sock:
                attacks.read_header(sock)
                (size,) = struct.unpack("<I", attacks.read_exactly(sock, 4))
                left = size
                while left:
                    part = sock.recv(min(left, 1 << 20))
                    assert part
                    left -= len(part)
