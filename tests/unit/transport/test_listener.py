"""The listening socket of servers in an event loop."""

from __future__ import annotations

import asyncio
import socket
import sys
from collections import Counter

import pytest

from rosproto.errors import ConnectionLost
from rosproto.transport import Listener
from rosproto.transport.connection_slots import ConnectionSlots


def test_small_messages_are_sent_at_once() -> None:
    """A pose must not wait until the page has acknowledged the one before, 40 ms later."""

    async def serve() -> int:
        found: asyncio.Future[int] = asyncio.get_running_loop().create_future()

        def come(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            sock = writer.get_extra_info("socket")
            found.set_result(sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        with Listener("127.0.0.1", 0, ConnectionSlots(256)) as listener:
            async with await asyncio.start_server(come, sock=listener):
                _, writer = await asyncio.open_connection(*listener.getsockname())
                value = await asyncio.wait_for(found, 20)
                writer.close()
        return value

    loop = asyncio.SelectorEventLoop()
    try:
        assert loop.run_until_complete(serve())
    finally:
        loop.close()


@pytest.mark.skipif(sys.platform == "darwin", reason="the BSDs let a wildcard listen beside one address")
def test_no_other_server_listens_on_all_addresses_of_the_port() -> None:
    """Windows would let it, if the socket did not ask to have the port alone."""
    with Listener("127.0.0.1", 0, ConnectionSlots(8)) as listener, pytest.raises(ConnectionLost):
        Listener("0.0.0.0", listener.getsockname()[1], ConnectionSlots(8))


def test_all_addresses_of_ipv6_are_not_those_of_ipv4() -> None:
    """Alike on all systems; and an IPv4 address has one spelling only, by which its connections are counted."""
    for _ in range(20):  # another program may have the port of that number at 127.0.0.1
        try:
            listener = Listener("[::]", 0, ConnectionSlots(8))
        except (ConnectionLost, OSError):
            pytest.skip("this system has no IPv6")
        with listener:
            try:
                Listener("127.0.0.1", listener.getsockname()[1], ConnectionSlots(8)).close()
                return
            except ConnectionLost:
                continue
    pytest.fail("no port of all IPv6 addresses was free at 127.0.0.1")


def accepted(listener: Listener, opened: list[socket.socket]) -> socket.socket:
    opened.append(socket.create_connection(listener.getsockname(), 20))
    connection, _ = listener.accept()
    opened.append(connection)
    return connection


def test_a_connection_frees_its_slot_when_it_is_closed_and_one_without_a_request_is_counted() -> None:
    slots, refused, opened = ConnectionSlots(2), Counter[str](), list[socket.socket]()
    with Listener("127.0.0.1", 0, slots, refused) as listener:
        first, second = accepted(listener, opened), accepted(listener, opened)
        slots.request_begins(second.getpeername(), 0.0, authorized=True)
        first.close()
        second.close()
        assert len(slots) == 0
        assert refused == {"no handshake": 1}
        for _ in range(4):
            accepted(listener, opened)
        assert len(slots) == 2
        assert refused == {"no handshake": 1, "too many handshakes at a time": 2}
        for sock in opened:
            sock.close()


def test_a_connection_that_gets_no_slot_is_closed_and_the_next_one_is_accepted() -> None:
    """Nothing is read from it; what another client has asked for is not given up for it."""
    slots, opened = ConnectionSlots(1), list[socket.socket]()
    with Listener("127.0.0.1", 0, slots) as listener:
        served = accepted(listener, opened)
        slots.request_begins(served.getpeername(), 0.0, authorized=True)
        refused, other = (socket.create_connection(listener.getsockname(), 20) for _ in range(2))
        opened += [refused, other]
        listener.setblocking(False)
        with pytest.raises(BlockingIOError):
            listener.accept()
        for sock in (refused, other):
            try:
                assert sock.recv(1) == b""
            except ConnectionError:
                pass
        served.close()
        assert accepted(listener, opened).getpeername() == opened[-2].getsockname()
        for sock in opened:
            sock.close()
