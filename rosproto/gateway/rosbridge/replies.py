"""`Replies`: sends the messages that a client's `Protocol` writes, from any thread."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rosproto.gateway.client_channel import ClientChannel
from rosproto.gateway.rosbridge.fields import Id
from rosproto.gateway.rosbridge.operations import Payload
from rosproto.gateway.rosbridge.protocol import Protocol
from rosproto.gateway.rosbridge.status_levels import Level


class Replies:
    """Sends to one client.

    Args:
        protocol: Writes the messages; it is locked, as it is not thread-safe.
        channel: Sends them.
    """

    def __init__(self, protocol: Protocol, channel: ClientChannel) -> None:
        self.protocol = protocol
        self._channel = channel
        self._lock = threading.Lock()

    def status(self, level: Level, text: str, id: Id = None) -> None:
        """Send a status, if the client wants this level."""
        self._channel.answer(self.protocol.status(level, text, id))

    def send(self, write: Callable[..., tuple[Payload, ...]], *args: Any, **more: Any) -> None:
        """Send what a method of the protocol writes, called with these arguments."""
        with self._lock:
            payloads = write(*args, **more)
        self._channel.answer(payloads)

    def cut(self, text: str, size: int | None) -> tuple[Payload, ...]:
        """Cut a message into fragments; see `Protocol.publish`."""
        with self._lock:
            return self.protocol.publish(text, size)
