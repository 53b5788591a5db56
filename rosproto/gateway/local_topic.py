"""`LocalTopic`: a topic of this program that only viewers see; it is not registered at the master."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import ExitStack

from rosproto.codec import Message, encode
from rosproto.gateway.message_event import MessageEvent, TopicDescription
from rosproto.gateway.shared_subscriptions import Receiver, offer
from rosproto.time import Time


class LocalTopic:
    """A topic of this program, passed as `Foxglove(topics=[...])`.

    It is latched: viewers that subscribe later get the last message.

    Args:
        name: "/woosh/overlay".
        type: Class of its messages.
        wanted: Called with True when the first viewer subscribes and with False when the last one has
            gone, in a thread that may wait. Without viewers no messages need be made.
    """

    def __init__(
        self, name: str, type: type[Message], wanted: Callable[[bool], object] | None = None
    ) -> None:
        self.name = name
        self.type = type
        self.description = TopicDescription(
            name, type._type, type._md5sum, type._full_text, latched=True, publisher=""
        )
        self._wanted = wanted
        self._opening = threading.Lock()
        self._lock = threading.Lock()
        self._receivers: tuple[Receiver, ...] = ()
        self._last: MessageEvent | None = None

    @property
    def receivers(self) -> int:
        """Number of viewers subscribed now."""
        return len(self._receivers)

    def publish(self, message: Message, stamp: Time | None = None) -> None:
        """Encode a message and send it to all viewers."""
        now = Time(*divmod(time.time_ns(), 1_000_000_000)) if stamp is None else stamp
        event = MessageEvent(self.description, encode(message), time.monotonic(), now)
        with self._lock:
            self._last = event
            receivers = self._receivers
        for receiver in receivers:
            offer(receiver, event)

    def open(self, receiver: Receiver) -> ExitStack:
        """Add a receiver; close what this returns to remove it."""
        with self._opening:
            with self._lock:
                first = not self._receivers
                self._receivers = (*self._receivers, receiver)
                last = self._last
            if first and self._wanted is not None:
                self._wanted(True)
        if last is not None:
            offer(receiver, last)
        subscription = ExitStack()
        subscription.callback(self.leave, receiver)
        return subscription

    def leave(self, receiver: Receiver) -> None:
        """Remove a receiver."""
        with self._opening:
            with self._lock:
                before = self._receivers
                self._receivers = tuple(other for other in before if other is not receiver)
                none_left = bool(before) and not self._receivers
            if none_left and self._wanted is not None:
                self._wanted(False)

    def __repr__(self) -> str:
        return f"<LocalTopic {self.name} {self.type._type}, {self.receivers} receivers>"
