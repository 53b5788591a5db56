"""`TopicSubscription`: a topic for one client, throttled, queued and encoded by the client's settings.

A client may subscribe to a topic several times, with different ids. It gets each message once, by combined
settings (shortest interval, shortest queue, smallest fragments, most compact encoding), as in
rosbridge_library's `subscribe` and `subscription_modifiers`. A message is encoded once for all clients.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rosproto.errors import RosError
from rosproto.gateway.access import Refused
from rosproto.gateway.chunks import ChunkedMessage
from rosproto.gateway.client_channel import ClientChannel, Payload
from rosproto.gateway.message_event import MessageEvent
from rosproto.gateway.rosbridge.cbor import publish_cbor, publish_cbor_raw
from rosproto.gateway.rosbridge.fields import Compression, Id
from rosproto.gateway.rosbridge.operations import Subscribe
from rosproto.gateway.rosbridge.png import publish_png
from rosproto.gateway.rosbridge.protocol import publish_chunks, publish_text
from rosproto.gateway.values import definition_name, to_json, to_json_parts

if TYPE_CHECKING:
    from rosproto.gateway.shared_subscriptions import SharedSubscription

QUICK_BYTES = 16 << 10
"""A message of at most this size is encoded without a thread."""
LONG_BYTES = 64 << 10
"""A longer message is encoded, kept and sent in chunks."""
_RANK: dict[Compression, int] = {"none": 0, "png": 1, "cbor": 2, "cbor-raw": 3}


@dataclass(frozen=True, slots=True)
class Settings:
    """A client's settings for a topic.

    Attributes:
        interval: Minimum seconds between two messages.
        queue_length: Most messages delayed by `interval`; with 0, early messages are dropped.
        fragment_size: Longest text that is not split into fragments; None for no limit.
        compression: The encoding.
    """

    interval: float = 0.0
    queue_length: int = 0
    fragment_size: int | None = None
    compression: Compression = "none"


def combined(asked: list[Subscribe]) -> Settings:
    """The combined settings of all subscriptions of a topic by one client."""
    sizes = [each.fragment_size for each in asked if each.fragment_size is not None]
    return Settings(
        interval=min(each.throttle_rate for each in asked) / 1000.0,
        queue_length=min(each.queue_length for each in asked),
        fragment_size=min(sizes, default=None),
        compression=max((each.compression for each in asked), key=_RANK.__getitem__),
    )


class Throttle:
    """Decides when messages are sent. Pure: callers pass the time."""

    def __init__(self) -> None:
        self._last = float("-inf")
        self._queue: deque[MessageEvent] = deque()

    @property
    def waits(self) -> bool:
        """Whether messages are delayed."""
        return bool(self._queue)

    def offer(self, event: MessageEvent, now: float, settings: Settings) -> MessageEvent | None:
        """Take a message; return the one to send now, if any."""
        if settings.interval <= 0.0 and not self._queue:
            return event
        early = now < self._last + settings.interval
        if settings.queue_length <= 0:
            self._queue.clear()
            if early:
                return None
            self._last = now
            return event
        self._queue.append(event)
        while len(self._queue) > settings.queue_length:
            self._queue.popleft()
        return self.due(now, settings)

    def due(self, now: float, settings: Settings) -> MessageEvent | None:
        """The oldest delayed message, if it is due."""
        if not self._queue or now < self._last + settings.interval:
            return None
        self._last = now
        return self._queue.popleft()

    def next_due(self, settings: Settings) -> float | None:
        """The time of the next delayed message; None if there is none."""
        return self._last + settings.interval if self._queue else None

    def clear(self) -> None:
        """Drop all delayed messages."""
        self._queue.clear()


def encoded(event: MessageEvent, topic: str, compression: Compression) -> Payload:
    """The rosbridge message with a received message; encoded once for all clients.

    Args:
        event: The message.
        topic: The topic as the client writes it.
        compression: The encoding.

    Raises:
        RosError: The message cannot be decoded.
    """
    return event.once((compression, topic), _ENCODERS[compression], event, topic)


def _raw(event: MessageEvent, topic: str) -> bytes | ChunkedMessage:
    return publish_cbor_raw(topic, event.stamp.secs, event.stamp.nsecs, event.data)


def _cbor(event: MessageEvent, topic: str) -> bytes:
    return publish_cbor(topic, event.message)


def _png(event: MessageEvent, topic: str) -> str:
    return publish_png(event.once(("none", topic), _text, event, topic))


def _text(event: MessageEvent, topic: str) -> str | ChunkedMessage:
    if len(event.data) <= LONG_BYTES:
        return publish_text(topic, to_json(event.message))
    return publish_chunks(topic, to_json_parts(event.message))


_ENCODERS: dict[Compression, Callable[[MessageEvent, str], Payload]] = {
    "none": _text,
    "png": _png,
    "cbor": _cbor,
    "cbor-raw": _raw,
}


Split = Callable[[str, int | None], tuple[str | bytes, ...]]
"""Splits a text into fragments: `Protocol.split` of the client."""


@dataclass(frozen=True, slots=True)
class _DeferredMessage:
    """A message that is encoded, and split into fragments, when the client is ready for it."""

    subscription: TopicSubscription
    event: MessageEvent
    settings: Settings

    @property
    def quick(self) -> bool:
        return len(self.event.data) <= QUICK_BYTES

    def payloads(self) -> tuple[Payload, ...]:
        return self.subscription.payloads(self.event, self.settings)


class TopicSubscription:
    """A topic for one client; a `Receiver`.

    Args:
        topic: As the client writes it; part of every message.
        channel: Sends to the client.
        split: Splits texts into fragments.
        failed: Called once if a message cannot be decoded.
        other_type: Called with the type of a message that is not the client's; no further message is sent.
            `offer` calls it, so it must not wait.
    """

    def __init__(
        self,
        topic: str,
        channel: ClientChannel,
        split: Split,
        failed: Callable[[str, RosError], object],
        other_type: Callable[[TopicSubscription, str], object],
    ) -> None:
        self.topic = topic
        self._shared: SharedSubscription | None = None
        self._channel = channel
        self._split = split
        self._failed = failed
        self._other_type = other_type
        self._type = ""
        self._lock = threading.Lock()
        self._asked: dict[Id, Subscribe] = {}
        self._settings = Settings()
        self._throttle = Throttle()
        self._ticking = False
        self._failure_reported = False
        self._closed = False

    def add(self, asked: Subscribe) -> None:
        """Add a subscription, or change the one with the same id.

        Raises:
            Refused: It has another type than those before it.
        """
        kind = definition_name(asked.type) if asked.type else ""
        with self._lock:
            if kind and self._type and kind != self._type:
                raise Refused(f"{self.topic} is already subscribed as {self._type}, not {kind[:200]}")
            self._type = self._type or kind
            self._asked[asked.id] = asked
            self._settings = combined(list(self._asked.values()))

    def opened(self, shared: SharedSubscription) -> None:
        """Keep the subscription at the robot, which is closed with this one."""
        with self._lock:
            self._shared = shared
            closed = self._closed
        if closed:
            shared.close()

    def remove(self, id: Id) -> bool:
        """Remove a subscription, or without an id all of them; True if none is left."""
        with self._lock:
            if id is None:
                self._asked.clear()
            else:
                self._asked.pop(id, None)
            if self._asked:
                self._settings = combined(list(self._asked.values()))
            return not self._asked

    @property
    def type_name(self) -> str:
        """The type that the client expects; "" for any."""
        return self._type

    @property
    def count(self) -> int:
        """Number of subscriptions of this topic."""
        return len(self._asked)

    def offer(self, event: MessageEvent) -> None:
        """Take a message, in the thread that received it."""
        with self._lock:
            if self._closed:
                return
            settings = self._settings
            other = self._type not in ("", event.type_name)
            self._closed = other
            first: MessageEvent | None = event
            if (not other and settings.interval > 0.0) or self._throttle.waits:
                now = time.monotonic()
                first = self._throttle.offer(event, now, settings)
                self._tick_later(now, settings)
        if other:
            self._other_type(self, event.type_name)
        elif first is not None:
            self._send(first, settings)

    def _tick_later(self, now: float, settings: Settings) -> None:
        due = self._throttle.next_due(settings)
        if due is not None and not self._ticking:
            self._ticking = True
            self._channel.later(max(0.0, due - now), self._tick)

    def _tick(self) -> None:
        """Send a delayed message; in the server's loop."""
        with self._lock:
            self._ticking = False
            if self._closed:
                return
            settings = self._settings
            now = time.monotonic()
            event = self._throttle.due(now, settings)
            self._tick_later(now, settings)
        if event is not None:
            self._send(event, settings, late=True)

    def _send(self, event: MessageEvent, settings: Settings, *, late: bool = False) -> None:
        """Encode and send; if the client is behind, or wants fragments, encode only when it is ready."""
        put, keep = self._channel.outbox.put, settings.queue_length or None
        if late or self._channel.behind or settings.fragment_size is not None:
            put(self.topic, len(event.data), _DeferredMessage(self, event, settings), keep)
            return
        for payload in self.payloads(event, settings):
            put(self.topic, len(payload), payload, keep)

    def payloads(self, event: MessageEvent, settings: Settings) -> tuple[Payload, ...]:
        """The payloads of a message; none if it cannot be decoded, which is reported once."""
        try:
            payload = encoded(event, self.topic, settings.compression)
        except RosError as error:
            if not self._failure_reported:
                self._failure_reported = True
                self._failed(self.topic, error)
            return ()
        if settings.fragment_size is None or isinstance(payload, bytes):
            return (payload,)
        if isinstance(payload, ChunkedMessage):
            if settings.compression == "cbor-raw":
                return (payload,)
            payload = payload.text()
        return self._split(payload, settings.fragment_size)

    def close(self) -> None:
        """Stop sending, drop what waits, and leave the topic."""
        self.leave()
        self._channel.outbox.forget(self.topic)

    def leave(self) -> None:
        """Leave the topic; what waits is still sent."""
        with self._lock:
            self._closed = True
            self._throttle.clear()
            shared = self._shared
        if shared is not None:
            shared.close()
