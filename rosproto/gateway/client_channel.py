"""One connected client, as everything above the socket sees it: what is sent to it, and its end."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from rosproto.gateway.chunks import ChunkedMessage
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.outbox import Outbox

Payload = str | bytes | ChunkedMessage
"""One message of a WebSocket: text or binary, whole or in chunks."""


class DeferredPayload(Protocol):
    """Payloads that are made when they are sent, for a client that may never take them."""

    @property
    def quick(self) -> bool:
        """Whether `payloads` takes no time worth a thread."""

    def payloads(self) -> tuple[Payload, ...]:
        """What is to be sent."""


class ClientSession(Protocol):
    """What a server does with one client's messages."""

    @property
    def longest(self) -> int:
        """Bytes that the next message may have; a longer one ends the connection unread."""

    async def received(self, data: str | bytes) -> None:
        """A message; the next one is read when this is done. Runs in the server's loop."""

    def ended(self) -> None:
        """The connection is over; called once, in a thread that may wait some seconds."""


class ClientChannel:
    """The way to one client; every method may be called from any thread.

    Attributes:
        peer: Its address, "10.0.0.7:51234".
        since: When it came, by the monotonic clock.
        outbox: What waits for it.
        busy: A message is on its way that the client has not taken.
        sent, sent_bytes: Messages written.
        received: Messages read.
        ending: (code, reason) of the close that was asked for; None while there is none.
        gone: The connection is over. What came before its end is still read.
        lost: It was torn down: what came before is not read any more, as nobody knows how old it is.
        subprotocol: The one that was agreed on; None where there is none.
    """

    def __init__(
        self,
        peer: str,
        limits: GatewayLimits,
        wake: Callable[[ClientChannel], object],
        end: Callable[[ClientChannel], object],
        later: Callable[[float, Callable[[], object]], object],
        subprotocol: str | None = None,
    ) -> None:
        self.peer = peer
        self.since = time.monotonic()
        self.outbox: Outbox[Payload | DeferredPayload] = Outbox(limits, lambda: wake(self))
        self.busy = False
        self.sent = self.sent_bytes = 0
        self.received = 0
        self.ending: tuple[int, str] | None = None
        self.gone = False
        self.lost = False
        self.subprotocol = subprotocol
        self._end = end
        self.later = later
        """`later(seconds, function)`: have it called in the server's loop; it must not block."""

    @property
    def dropped(self) -> int:
        """Messages of topics that it was too slow for."""
        return sum(self.outbox.dropped.values())

    def written(self, payload: Payload) -> None:
        """Count a message."""
        self.sent += 1
        self.sent_bytes += len(payload)

    @property
    def behind(self) -> bool:
        """Whether something waits that it has not taken yet."""
        return self.busy or len(self.outbox) > 0

    def answer(self, payloads: tuple[str | bytes, ...]) -> None:
        """Send something that is never dropped; a client that does not take its answers is cut off."""
        for payload in payloads:
            self.answer_deferred(len(payload), payload)

    def answer_deferred(self, size: int, payload: Payload | DeferredPayload) -> None:
        """As `answer`, of what counts for so many bytes while it waits."""
        self.outbox.put(None, size, payload)
        if self.outbox.overflow:
            self.close(1013, "answers wait that are not read")

    def offer(
        self, key: object, size: int, payload: Payload | DeferredPayload, keep: int | None = None
    ) -> None:
        """Send a message of a topic, if the client keeps up; see `Outbox.put`."""
        self.outbox.put(key, size, payload, keep)

    def close(self, code: int, reason: str) -> None:
        """End the connection, with a WebSocket close code; what waits is not sent."""
        if self.ending is None:
            self.ending = code, reason[:120]
            self._end(self)

    def __repr__(self) -> str:
        return f"<Channel {self.peer}, {len(self.outbox)} waiting>"
