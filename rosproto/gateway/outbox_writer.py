"""`OutboxWriter`: writes the payloads of all outboxes to their WebSockets, at each client's speed.

A short message for a client that keeps up is written at once, in the same turn of the loop, because waking
the client's task takes several times as long. The client's task writes long messages, in parts between which
other clients are served, and everything for a client that is behind.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import AsyncIterator, Iterable
from typing import TYPE_CHECKING, TypeAlias

from rosproto.aio.pool import Pool, notify
from rosproto.gateway.chunks import CHUNK_SIZE, ChunkedMessage, pieces
from rosproto.gateway.client_channel import ClientChannel, DeferredPayload, Payload
from rosproto.logs import PeerLog

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.exceptions import ConnectionClosed

    Client: TypeAlias = tuple[ServerConnection, asyncio.Transport, asyncio.Event, asyncio.Task[None]]

SHORT = 16 << 10  # bytes of a message that is written without its client's task
TURN_MESSAGES = 64  # messages written to one client before others have their turn


def closed_error() -> type[ConnectionClosed]:
    """The exception for a closed connection."""
    from websockets.exceptions import ConnectionClosed

    return ConnectionClosed


class OutboxWriter:
    """Writes to all clients of a server. Everything but `wake` runs in the loop's thread.

    Args:
        loop: The server's loop.
        pool: Threads for payloads that take time to make.
        peer_log: Logs messages that could not be sent.
        name: The server's name in the log.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, pool: Pool, peer_log: PeerLog, name: str) -> None:
        from websockets.asyncio.server import broadcast

        self._loop = loop
        self._pool = pool
        self._peer_log = peer_log
        self._name = name
        self._lock = threading.Lock()
        self._woken: deque[ClientChannel] = deque()
        self._wake_scheduled = False
        self._clients: dict[ClientChannel, Client] = {}
        self._closed_error = closed_error()
        self._broadcast = broadcast

    def add(self, channel: ClientChannel, connection: ServerConnection, transport: asyncio.Transport) -> None:
        """Start writing to a client."""
        event = asyncio.Event()
        task = asyncio.ensure_future(self._write(channel, connection, event))
        self._clients[channel] = connection, transport, event, task

    def remove(self, channel: ClientChannel) -> None:
        """Stop writing to a client that has gone."""
        *_, task = self._clients.pop(channel)
        task.cancel()

    def wake(self, channel: ClientChannel) -> None:
        """A payload waits for a client; from any thread. Several wakes are handled together."""
        with self._lock:
            self._woken.append(channel)
            scheduled, self._wake_scheduled = self._wake_scheduled, True
        if not scheduled:
            notify(self._loop, self._wake_all)

    def _wake_all(self) -> None:
        with self._lock:
            woken, self._woken = self._woken, deque()
            self._wake_scheduled = False
        for channel in woken:
            client = self._clients.get(channel)
            if client is not None and not self._write_at_once(channel, *client[:2]):
                client[2].set()

    def _write_at_once(
        self, channel: ClientChannel, connection: ServerConnection, transport: asyncio.Transport
    ) -> bool:
        """Write waiting short payloads while the client keeps up; True if nothing is left."""
        for _ in range(TURN_MESSAGES):
            # `broadcast` skips a client that is receiving a long message, or has gone.
            if (
                channel.busy
                or transport.get_write_buffer_size()
                or transport.is_closing()
                or (item := channel.outbox.take(SHORT)) is None
            ):
                break
            try:
                for payload in _payloads(item):
                    assert not isinstance(payload, ChunkedMessage)  # these are long
                    self._broadcast((connection,), payload)
                    channel.written(payload)
            except Exception as error:
                self._say_not_sent(channel, error)
        return not channel.outbox

    async def _write(
        self, channel: ClientChannel, connection: ServerConnection, event: asyncio.Event
    ) -> None:
        """Write the payloads of one client in order, until its connection ends."""
        turn = 0
        while True:
            item = channel.outbox.take()
            if item is None:
                event.clear()
                await event.wait()
                continue
            channel.busy = True
            try:
                if isinstance(item, (str, bytes, ChunkedMessage)) or item.quick:
                    payloads = _payloads(item)
                else:
                    payloads = await self._pool.run(item.payloads)
                for payload in payloads:
                    if isinstance(payload, ChunkedMessage) or len(payload) > CHUNK_SIZE:
                        await connection.send(_in_turns(payload))
                    else:
                        await connection.send(payload)
                    channel.written(payload)
            except self._closed_error:
                return
            except Exception as error:
                self._say_not_sent(channel, error)
            finally:
                channel.busy = False
            turn += 1
            if turn % TURN_MESSAGES == 0:
                await asyncio.sleep(0)

    def _say_not_sent(self, channel: ClientChannel, error: Exception) -> None:
        self._peer_log.error(channel.peer, "! %s: a message to %s", self._name, channel.peer, exc_info=error)


def _payloads(item: Payload | DeferredPayload) -> tuple[Payload, ...]:
    return (item,) if isinstance(item, (str, bytes, ChunkedMessage)) else item.payloads()


async def _in_turns(payload: Payload) -> AsyncIterator[str | bytes | memoryview]:
    """The frames of a long message, with turns for other clients in between."""
    if isinstance(payload, ChunkedMessage):
        chunks: Iterable[str | bytes | memoryview] = payload.chunks
    else:
        chunks = pieces(payload) if isinstance(payload, str) else pieces(memoryview(payload))
    for chunk in chunks:
        yield chunk
        await asyncio.sleep(0)
