"""Writes what waits in the clients' outboxes to their WebSockets, each at the speed its client takes it.

A short message, while its client takes what it is sent, is written in the turn of the loop in which it
comes: to wake each client's task for it takes several times as long. What is long, or waits for its client,
is written by the client's task, in parts between which others have their turn.
"""

from __future__ import annotations

import asyncio
import sys
import threading
from collections import deque
from collections.abc import AsyncIterator, Iterator
from importlib import import_module
from typing import Any

from rosproto.aio.pool import Pool, notify
from rosproto.gateway.chunks import CHUNK_SIZE, ChunkedMessage
from rosproto.gateway.client_channel import ClientChannel, DeferredPayload, Payload
from rosproto.logs import PeerLog

SHORT = 16 << 10  # bytes of a message that is written without its client's task
TURN = 64  # messages written to one client before others have their turn


def closed_error() -> Any:
    """The exception that says that a connection is over."""
    return import_module("websockets.exceptions").ConnectionClosed


class OutboxWriter:
    """The clients' writers. Everything runs in the loop's thread, but for `wake`.

    Args:
        loop: The server's.
        pool: Threads for what takes time to be made.
        peer_log: Where it is told what could not be sent.
        name: In those words.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, pool: Pool, peer_log: PeerLog, name: str) -> None:
        self._loop = loop
        self._pool = pool
        self._peer_log = peer_log
        self._name = name
        self._lock = threading.Lock()
        self._woken: deque[ClientChannel] = deque()
        self._wake_scheduled = False
        self._clients: dict[ClientChannel, tuple[Any, Any, asyncio.Event]] = {}
        self._tasks: dict[ClientChannel, asyncio.Future[None]] = {}
        self._closed_error = closed_error()
        self._broadcast = import_module("websockets.asyncio.server").broadcast

    def add(self, channel: ClientChannel, connection: Any, transport: asyncio.Transport) -> None:
        """Begin to write to a client, by its WebSocket over this transport."""
        self._clients[channel] = connection, transport, asyncio.Event()
        self._tasks[channel] = asyncio.ensure_future(self._write(channel))

    def remove(self, channel: ClientChannel) -> None:
        """It has gone."""
        del self._clients[channel]
        self._tasks.pop(channel).cancel()

    def wake(self, channel: ClientChannel) -> None:
        """Something waits for a client; from any thread. One wake does for all that comes together."""
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

    def _write_at_once(self, channel: ClientChannel, connection: Any, transport: asyncio.Transport) -> bool:
        """Write what waits, as far as it is short and the client takes it; True when nothing is left."""
        for _ in range(TURN):
            # `broadcast` passes over a client that is being sent a long message, or has gone.
            if (
                channel.busy
                or transport.get_write_buffer_size()
                or transport.is_closing()
                or (item := channel.outbox.take(SHORT)) is None
            ):
                break
            try:
                for payload in _payloads(item):
                    self._broadcast((connection,), payload)
                    channel.written(payload)
            except Exception:
                self._say_not_sent(channel)
        return not channel.outbox

    async def _write(self, channel: ClientChannel) -> None:
        """What waits for a client, one after the other; ends with its connection."""
        connection, _, event = self._clients[channel]
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
                    long = isinstance(payload, ChunkedMessage) or len(payload) > CHUNK_SIZE
                    await connection.send(_in_turns(payload) if long else payload)
                    channel.written(payload)
            except self._closed_error:
                return
            except Exception:
                self._say_not_sent(channel)
            finally:
                channel.busy = False
            turn += 1
            if turn % TURN == 0:
                await asyncio.sleep(0)

    def _say_not_sent(self, channel: ClientChannel) -> None:
        self._peer_log.error(
            channel.peer, "! %s: a message to %s", self._name, channel.peer, exc_info=sys.exc_info()[1]
        )


def _payloads(item: Payload | DeferredPayload) -> tuple[Payload, ...]:
    return (item,) if isinstance(item, (str, bytes, ChunkedMessage)) else item.payloads()


async def _in_turns(payload: Payload) -> AsyncIterator[str | bytes | memoryview]:
    """A long message as the frames of a fragmented one: a map does not hold up the other clients."""
    for chunk in payload.chunks if isinstance(payload, ChunkedMessage) else _cut(payload):
        yield chunk
        await asyncio.sleep(0)


def _cut(payload: str | bytes) -> Iterator[str | memoryview]:
    whole = payload if isinstance(payload, str) else memoryview(payload)
    return (whole[at : at + CHUNK_SIZE] for at in range(0, len(whole), CHUNK_SIZE))
