"""`SharedSubscriptions`: each topic is subscribed once at the robot, for all clients of a gateway.

A topic is subscribed for the first receiver, and unsubscribed some time after the last one has gone. Messages
arrive as bytes; a `MessageEvent` decodes them on first use, once for all receivers. Receivers are called in
the thread that received the message and must not block: they put it into an outbox.
"""

from __future__ import annotations

import threading
import time
from typing import Protocol

from rosproto.codec import AnyMsg
from rosproto.errors import LocalProtocolError
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.message_event import MessageEvent, TopicDescription
from rosproto.logs import get_logger
from rosproto.node import Node, Subscriber
from rosproto.node.definitions.type_argument import bundled_text
from rosproto.time import Time

_log = get_logger("rosproto.gateway")

MAX_LATCHED = 100  # publishers of one topic whose last message is kept
MAX_DESCRIPTIONS = 100  # of the publishers of one topic
MAX_WAITING = 100  # messages of one topic that wait while its receivers are slow


class Receiver(Protocol):
    """A receiver of the messages of a topic."""

    def offer(self, event: MessageEvent) -> None:
        """Take a message; called in a thread of the library.

        The first call may come before `SharedSubscriptions.open` has returned. It must not block; exceptions
        are logged.
        """


def offer(receiver: Receiver, event: MessageEvent) -> None:
    """Give a message to a receiver, whose error must not affect the others."""
    try:
        receiver.offer(event)
    except Exception:
        _log.exception("! %s: a receiver of the gateway raised", event.topic)


class SharedSubscription:
    """One receiver's subscription of a topic; made by `SharedSubscriptions.open`. Close it at the end.

    Attributes:
        topic: Resolved name.
    """

    def __init__(self, shared_topic: _SharedTopic, receiver: Receiver) -> None:
        self.topic = shared_topic.topic
        self._shared_topic = shared_topic
        self.receiver = receiver
        self.closed = False

    @property
    def description(self) -> TopicDescription | None:
        """The topic as described by the publisher of the last message; None before the first one."""
        return self._shared_topic.latest

    @property
    def connections(self) -> int:
        """Publishers connected now."""
        subscriber = self._shared_topic.subscriber
        return 0 if subscriber is None else subscriber.connections

    def close(self) -> None:
        """Stop receiving; one more message may still come. May be called again."""
        self._shared_topic.remove(self)

    def __repr__(self) -> str:
        return f"<SharedSubscription {self.topic}{', closed' if self.closed else ''}>"


class SharedSubscriptions:
    """The topics subscribed for the clients of one gateway, or of several gateways on the same node.

    Args:
        node: The node that subscribes.
        limits: Only `linger_seconds` is used.
    """

    def __init__(self, node: Node, limits: GatewayLimits | None = None) -> None:
        self._node = node
        self._limits = limits or GatewayLimits()
        self._lock = threading.Lock()
        self._shared_topics: dict[str, _SharedTopic] = {}
        self._closed = False

    @property
    def topics(self) -> tuple[str, ...]:
        """Topics subscribed now, including those that linger."""
        with self._lock:
            return tuple(self._shared_topics)

    def open(self, topic: str, receiver: Receiver) -> SharedSubscription:
        """Send every message of a topic to a receiver, first the last one of each latching publisher.

        Calls the master, so it may take seconds while the master does not answer.

        Args:
            topic: Name of the topic.
            receiver: Gets the messages.

        Raises:
            LocalProtocolError: The node or this object is closed.
            MasterError, ConnectionLost, RosTimeout: The subscription could not be registered.
            ValueError: The name is not valid.
        """
        name = self._node.resolve_name(topic)
        while True:
            with self._lock:
                if self._closed:
                    raise LocalProtocolError(f"{name}: the gateway is closed")
                shared_topic = self._shared_topics.get(name)
                if shared_topic is None:
                    shared_topic = self._shared_topics[name] = _SharedTopic(self, self._node, name)
            subscription = shared_topic.add(receiver)
            if subscription is not None:
                return subscription
            # It was being unsubscribed: make another one.

    def forget(self, shared_topic: _SharedTopic) -> None:
        """Remove a topic that has been unsubscribed."""
        with self._lock:
            if self._shared_topics.get(shared_topic.topic) is shared_topic:
                del self._shared_topics[shared_topic.topic]

    @property
    def linger(self) -> float:
        """Seconds that a topic is kept without receivers."""
        return 0.0 if self._closed else self._limits.linger_seconds

    def close(self) -> None:
        """Unsubscribe all topics now. May be called again."""
        with self._lock:
            self._closed = True
            shared_topics = list(self._shared_topics.values())
        for shared_topic in shared_topics:
            shared_topic.end()


class _SharedTopic:
    """One topic at the robot.

    `_state` guards the receivers; `_opening` is held while the master is called, which may take seconds.
    """

    def __init__(self, shared_subscriptions: SharedSubscriptions, node: Node, topic: str) -> None:
        self.topic = topic
        self.subscriber: Subscriber | None = None
        self.latest: TopicDescription | None = None
        self._shared_subscriptions = shared_subscriptions
        self._node = node
        self._clock = node.clock
        self._opening = threading.Lock()
        self._state = threading.Lock()
        self._receivers: tuple[SharedSubscription, ...] = ()
        self._latched: dict[str, MessageEvent] = {}  # by publisher
        self._timer: threading.Timer | None = None
        self._ended = False
        self._descriptions: dict[tuple[object, ...], TopicDescription] = {}
        self._warned = False

    # -- receivers ------------------------------------------------------------------------------------------

    def add(self, receiver: Receiver) -> SharedSubscription | None:
        """Add a receiver; None if this topic is being unsubscribed."""
        subscription = SharedSubscription(self, receiver)
        with self._state:
            if self._ended:
                return None
            self._stop_timer()
            for event in self._still_latched():
                offer(subscription.receiver, event)
            self._receivers = (*self._receivers, subscription)
        try:
            self._subscribe()
        except BaseException:
            self.remove(subscription)
            raise
        return subscription

    def _subscribe(self) -> None:
        with self._opening:
            if self.subscriber is None and not self._ended:
                self.subscriber = self._node.subscriber(
                    self.topic, AnyMsg, self._received, queue_size=MAX_WAITING, raw=True
                )

    def remove(self, subscription: SharedSubscription) -> None:
        with self._state:
            if subscription.closed:
                return
            subscription.closed = True
            self._receivers = tuple(other for other in self._receivers if other is not subscription)
            if self._receivers or self._ended:
                return
            linger = self._shared_subscriptions.linger
            if linger > 0.0 and self.subscriber is not None:
                self._timer = threading.Timer(linger, self.end, kwargs={"only_if_unused": True})
                self._timer.daemon = True
                self._timer.name = f"rosproto:leave {self.topic}"
                self._timer.start()
                return
        self.end(only_if_unused=True)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def end(self, *, only_if_unused: bool = False) -> None:
        """Unsubscribe."""
        with self._state:
            if self._ended or (only_if_unused and self._receivers):
                return
            self._ended = True
            self._stop_timer()
            for subscription in self._receivers:
                subscription.closed = True
            self._receivers = ()
            self._latched.clear()
        self._shared_subscriptions.forget(self)
        with self._opening:
            if self.subscriber is not None:
                self.subscriber.close()

    # -- messages -------------------------------------------------------------------------------------------

    def _received(self, message: AnyMsg) -> None:
        """Called in the thread of the publisher's connection."""
        description = self._described(message._connection_header or {})
        if description is None:
            return
        stamp = Time.from_wire(*divmod(self._clock.now_nsec(), 1_000_000_000))
        event = MessageEvent(description, message._buff, time.monotonic(), stamp)
        with self._state:
            self.latest = description
            if description.latched:
                self._remember(description.publisher, event)
            receivers = self._receivers
        for subscription in receivers:
            if not subscription.closed:
                offer(subscription.receiver, event)

    def _remember(self, publisher: str, event: MessageEvent) -> None:
        self._latched.pop(publisher, None)
        while len(self._latched) >= MAX_LATCHED:
            self._latched.pop(next(iter(self._latched)))
        self._latched[publisher] = event

    def _still_latched(self) -> list[MessageEvent]:
        """The latched messages, without those of publishers that have gone."""
        if self.subscriber is None or not self._latched:
            return []
        present = set(self.subscriber.publishers)
        self._latched = {name: event for name, event in self._latched.items() if name in present}
        return list(self._latched.values())

    def _described(self, header: dict[str, str]) -> TopicDescription | None:
        """The publisher's own description; the same object as long as it is equal."""
        kind, md5sum = header.get("type", "*"), header.get("md5sum", "*")
        publisher, latched = header.get("callerid", ""), header.get("latching") == "1"
        if kind == "*" or md5sum == "*":
            if not self._warned:
                self._warned = True
                _log.warning(
                    "! %s: %s publishes AnyMsg, whose type is unknown; no client gets it",
                    self.topic,
                    publisher[:200],
                )
            return None
        text = header.get("message_definition", "")
        key = kind, md5sum, text, latched, publisher
        known = self._descriptions.get(key)
        if known is None:
            if len(self._descriptions) >= MAX_DESCRIPTIONS:
                self._descriptions.clear()
            text = text or bundled_text(kind, md5sum)
            known = self._descriptions[key] = TopicDescription(
                self.topic, kind, md5sum, text, latched=latched, publisher=publisher
            )
        return known
