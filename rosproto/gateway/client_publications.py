"""`ClientPublications`: the topics that clients publish, each with a publisher of the node.

When a client closes its publication, the publisher stays for a while: zero velocities may have to follow
(`velocity_watchdog.py`), and a reloaded page advertises the topic again at once.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Hashable

from rosproto.codec import Message, encode
from rosproto.errors import LocalProtocolError
from rosproto.gateway.topic_type import insist_type
from rosproto.gateway.velocity_watchdog import VelocityWatchdog, is_velocity
from rosproto.logs import get_logger
from rosproto.node import Node, Publisher
from rosproto.watchdog import LastMessage, Watchdog, watched_node_of

_log = get_logger("rosproto.gateway")

LINGER = 2.0  # seconds from the close of a publication to that of its publisher; zeros take half of one
EARLY_SECONDS = 1.0
EARLY_MESSAGES = 100
EARLY_BYTES = 4 << 20
LATE_VELOCITIES = 1  # that wait for a slow robot; old ones are useless


class _EarlyMessages:
    """Messages published in the first second, kept for subscribers that connect within it."""

    def __init__(self) -> None:
        self._until = time.monotonic() + EARLY_SECONDS
        self._lock = threading.Lock()
        self._sent: deque[tuple[bytes, set[str]]] = deque(maxlen=EARLY_MESSAGES)
        self._bytes = 0
        self.publisher: Publisher | None = None

    def publish(self, message: Message | bytes) -> bool:
        """Publish a message and remember its receivers; False after the second, or if too much is kept."""
        publisher = self.publisher
        if publisher is None or time.monotonic() > self._until:
            self._sent.clear()
            return False
        data = message if isinstance(message, bytes) else encode(message)
        with self._lock:
            self._bytes += len(data)
            if self._bytes > EARLY_BYTES:
                return False
            present = set(publisher.subscribers)
            for caller_id in present:  # one may have connected, and `connected` is not called yet
                self._catch_up(publisher, caller_id)
            self._sent.append((data, present))
            publisher.publish(data)
        return True

    def connected(self, caller_id: str) -> None:
        """Called in a thread of the library when a subscriber has connected."""
        publisher = self.publisher
        if publisher is None or time.monotonic() > self._until:
            return
        with self._lock:
            self._catch_up(publisher, caller_id)

    def _catch_up(self, publisher: Publisher, caller_id: str) -> None:
        """Send a subscriber what it has missed, in order. Called with the lock held."""
        for data, received in self._sent:
            if caller_id not in received and publisher.publish_to(caller_id, data):
                received.add(caller_id)


class ClientPublication:
    """A topic that one client publishes; made by `ClientPublications.open`. Close it at the end.

    Attributes:
        client: The client.
        topic: Resolved name.
        message_class: Class of its messages.
    """

    def __init__(
        self, owner: ClientPublications, client: Hashable, publisher: Publisher, early: _EarlyMessages | None
    ) -> None:
        self._owner = owner
        self._publisher = publisher
        self._early = early
        self.client = client
        self.topic = publisher.topic
        self.message_class: type[Message] = publisher.message_class
        self.closed = False

    def publish(
        self, message: Message | bytes, received: float | None = None, client: Hashable | None = None
    ) -> None:
        """Publish a message or its encoded bytes; never waits for a subscriber.

        Args:
            message: The message.
            received: When it came, by `time.monotonic()`; None means now.
            client: Whose velocity it is, where several clients share this; None means `self.client`.

        Raises:
            CodecError: A value does not fit its field.
            LocalProtocolError: This is closed; or the velocity watchdog refuses the velocity.
        """
        if self.closed:
            raise LocalProtocolError(f"{self.topic}: no longer advertised")
        if self._early is not None:
            if self._early.publish(message):
                return
            self._early = None
        self._owner.velocity_watchdog.publish(client or self.client, self._publisher, message, received)

    def close(self) -> None:
        """Stop publishing; if the client drove there, zero follows. May be called again."""
        if not self.closed:
            self.closed = True
            self._owner.closed(self, self._publisher)


class ClientPublications:
    """Opens publications for clients.

    Args:
        node: The node that publishes.
        velocity_watchdog: Watches velocities.
        watchdog: Process that sends zero where a client drives if this process dies; None for none.
    """

    def __init__(
        self,
        node: Node,
        velocity_watchdog: VelocityWatchdog,
        *,
        watchdog: Watchdog | None = None,
    ) -> None:
        self.velocity_watchdog = velocity_watchdog
        self._watchdog = watchdog
        self._watching = threading.Lock()
        self._watched: set[str] = set()
        self._node = node
        self._lock = threading.Lock()
        self._leaving: dict[Publisher, threading.Timer] = {}
        self._open: set[Publisher] = set()
        self._closed = False

    def open(
        self,
        client: Hashable,
        topic: str,
        kind: type[Message],
        *,
        latch: bool = False,
        queue_size: int = 100,
    ) -> ClientPublication:
        """Publish a topic for a client; calls the master.

        Raises:
            Refused: Other nodes use the topic with another type.
            LocalProtocolError: This node publishes the topic with another type, or this is closed.
            MasterError, ConnectionLost, RosTimeout: It could not be registered.
        """
        if self._closed:
            raise LocalProtocolError(f"{topic}: the gateway is closed")
        insist_type(self._node, topic, kind._type)
        velocity = is_velocity(kind)
        early = None if velocity or latch else _EarlyMessages()
        opened: list[Publisher] = []

        def connected(caller_id: str) -> None:
            for publisher in opened:  # before, nothing was published by it
                self.velocity_watchdog.connected(publisher, caller_id)

        publisher = self._node.publisher(
            topic,
            kind,
            latch=latch,
            queue_size=LATE_VELOCITIES if velocity else max(1, queue_size),
            linger=not velocity,
            on_connect=connected if velocity else None if early is None else early.connected,
        )
        if early is not None:
            early.publisher = publisher
        opened.append(publisher)
        with self._lock:
            closed = self._closed
            if not closed:
                self._open.add(publisher)
        if closed:
            publisher.close()
            raise LocalProtocolError(f"{topic}: the gateway is closed")
        if velocity and self._watchdog is not None:
            self._watch(self._watchdog, publisher)
        return ClientPublication(self, client, publisher, early)

    def _watch(self, watchdog: Watchdog, publisher: Publisher) -> None:
        """Register the topic at the watchdog process, before the first velocity; waits until it is ready."""
        kind, topic = publisher.message_class, publisher.topic
        with self._watching:
            if topic in self._watched:
                return
            self._watched.add(topic)
            zero = LastMessage(topic, kind._type, kind._full_text, encode(kind()))
            self.velocity_watchdog.watch(
                topic, watchdog.watch(watched_node_of(self._node), messages=[zero], armed=False)
            )

    def closed(self, publication: ClientPublication, publisher: Publisher) -> None:
        """A publication was closed: send zero if needed, and close the publisher later."""
        self.velocity_watchdog.gone(publication.client, publication.topic)
        with self._lock:
            if self._closed or publisher not in self._open:
                return
            timer = threading.Timer(LINGER, self._leave, (publisher,))
            timer.daemon = True
            timer.name = f"rosproto:leave {publication.topic}"
            self._leaving[publisher] = timer
            timer.start()

    def _leave(self, publisher: Publisher) -> None:
        with self._lock:
            self._leaving.pop(publisher, None)
            self._open.discard(publisher)
            last = publisher.topic not in {each.topic for each in self._open}
        if last and publisher.topic in self._watched:
            with self._watching:
                self._watched.discard(publisher.topic)
                self.velocity_watchdog.unwatch(publisher.topic)
        _close(publisher)

    def close(self) -> None:
        """Send zeros (half a second if a client drives), then close all publishers. May be called again."""
        self.velocity_watchdog.close()
        with self._lock:
            self._closed = True
            timers, self._leaving = list(self._leaving.values()), {}
            publishers, self._open = list(self._open), set()
        for timer in timers:
            timer.cancel()
        for publisher in publishers:
            _close(publisher)


def _close(publisher: Publisher) -> None:
    try:
        publisher.close()
    except Exception as error:  # the master does not answer
        _log.debug("! %s: cannot be unregistered from the master: %s", publisher.topic, error)
