"""The socket of the web door."""

from __future__ import annotations

import asyncio
import socket
import sys

import pytest

pytest.importorskip("uvicorn", reason="uvicorn is not installed")

from rosproto.admission import ConnectionSlots
from woosh_pure.web.server import Listener


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


def test_an_address_of_another_computer_is_told_from_a_port_in_use() -> None:
    with (
        Listener("127.0.0.1", 0, ConnectionSlots(256)) as listener,
        pytest.raises(OSError, match="give another --port"),
    ):
        Listener("127.0.0.1", listener.getsockname()[1], ConnectionSlots(256))
    with pytest.raises(OSError, match="--bind takes an address of this computer"):
        Listener("192.0.2.1", 0, ConnectionSlots(256))  # RFC 5737: nobody has it
    with pytest.raises(OSError, match="--bind takes an address of this computer"):
        Listener("no-such-name.invalid", 0, ConnectionSlots(256))


@pytest.mark.skipif(sys.platform == "darwin", reason="the BSDs let a wildcard listen beside one address")
def test_no_other_server_listens_on_all_addresses_of_the_port() -> None:
    """Windows would let it, if the socket did not ask to have the port alone."""
    with (
        Listener("127.0.0.1", 0, ConnectionSlots(256)) as listener,
        pytest.raises(OSError, match="give another --port"),
    ):
        Listener("0.0.0.0", listener.getsockname()[1], ConnectionSlots(256))
