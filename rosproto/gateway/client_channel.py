"""`ClientChannel`: how a session sends to its client and closes the connection, and `ClientSession`."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from rosproto.gateway.chunks import ChunkedMessage
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.outbox import Outbox

Payload = str | bytes | ChunkedMessage
"""One WebSocket message: text or binary, whole or in chunks."""


class DeferredPayload(Protocol):
    """Payloads that are made only when the client is ready to receive them."""

    @property
    def quick(self) -> bool:
        """Whether `payloads` is too fast to be worth a thread."""

    def payloads(self) -> tuple[Payload, ...]:
        """Make the payloads."""


class ClientSession(Protocol):
    """Handles the messages of one client; the server calls it."""

    @property
    def max_message_bytes(self) -> int:
        """Longest next message in bytes; a longer one ends the connection unread."""

    async def received(self, data: str | bytes) -> None:
        """Handle a message, in the server's loop; the next one is read afterwards."""

    def ended(self) -> None:
        """The connection has ended; called once, in a thread that may wait some seconds."""


class ClientChannel:
    """Sends to one client; every method may be called from any thread.

    Attributes:
        peer: Its address, "10.0.0.7:51234".
        since: When it connected, by the monotonic clock.
        outbox: Payloads that wait for it; messages of topics are put there directly.
        busy: A message is being sent that the client has not taken yet.
        sent, sent_bytes: Messages written.
        received: Messages read.
        ending: (code, reason) of the requested close; None if there is none.
        gone: The connection has ended. Messages received before its end are still handled.
        lost: The connection broke: earlier messages are not handled, because their age is unknown.
        subprotocol: The agreed one, or None.
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
        """`later(seconds, function)`: call a function that does not block, in the server's loop."""

    def written(self, payload: Payload) -> None:
        """Count a written message."""
        self.sent += 1
        self.sent_bytes += len(payload)

    @property
    def behind(self) -> bool:
        """Whether payloads wait for the client."""
        return self.busy or len(self.outbox) > 0

    def answer(self, payloads: tuple[str | bytes, ...]) -> None:
        """Send payloads that are never dropped; a client that does not read its answers is disconnected."""
        for payload in payloads:
            self.answer_deferred(len(payload), payload)

    def answer_deferred(self, size: int, payload: Payload | DeferredPayload) -> None:
        """As `answer`, for a payload that counts as `size` bytes while it waits."""
        self.outbox.put(None, size, payload)
        if self.outbox.overflow:
            self.close(1013, "answers wait that are not read")

    def close(self, code: int, reason: str) -> None:
        """Close the connection with a WebSocket close code; waiting payloads are not sent."""
        if self.ending is None:
            self.ending = code, reason[:120]
            self._end(self)

    def __repr__(self) -> str:
        return f"<Channel {self.peer}, {len(self.outbox)} waiting>"
