"""What clients publish: one handle for each client and topic, with a publisher of the node behind it.

A handle that is closed leaves its publisher for some time: zeros may have to follow (`write_guard`), and a
page that is loaded anew advertises again at once.
"""

from __future__ import annotations

import threading
from collections.abc import Hashable
from typing import TYPE_CHECKING, Any

from rosproto.codec import Message
from rosproto.errors import LocalProtocolError
from rosproto.gateway.write_guard import WriteGuard, is_velocity
from rosproto.logs import get_logger

if TYPE_CHECKING:
    from rosproto.node import Node, Publisher

__all__ = ["Publication", "Publications"]

_log = get_logger("rosproto.gateway")

LINGER = 2.0  # seconds; the zeros take half of one
LATE_VELOCITIES = 1  # that wait for a slow robot: an old one is of no use


class Publication:
    """A topic that one client publishes; made by `Publications.open`. Close it.

    Attributes:
        client: Whose it is.
        topic: Resolved name.
        type_name: "package/Type".
        message_class: Class of its messages.
    """

    def __init__(self, owner: Publications, client: Hashable, publisher: Publisher) -> None:
        self._owner = owner
        self._publisher = publisher
        self.client = client
        self.topic = publisher.topic
        self.type_name = publisher.type_name
        self.message_class: type[Message] = publisher.message_class
        self.latch = publisher.latch
        self.closed = False

    def publish(self, message: Any) -> None:
        """Publish a message, or its encoded bytes; never waits for a robot.

        Raises:
            CodecError: A value does not fit its field.
            LocalProtocolError: This is closed.
        """
        if self.closed:
            raise LocalProtocolError(f"{self.topic}: not advertised any more")
        self._owner.guard.publish(self.client, self._publisher, message)

    @property
    def connections(self) -> int:
        """Subscribers connected now."""
        return self._publisher.connections

    def close(self) -> None:
        """Publish no more; zero follows where it drove. Twice is fine."""
        if not self.closed:
            self.closed = True
            self._owner.closed(self, self._publisher)


class Publications:
    """Opens what clients publish.

    Args:
        node: Publishes it.
        guard: Watches velocities.
        linger: Seconds that a publisher stays after its handle was closed.
    """

    def __init__(self, node: Node, guard: WriteGuard, *, linger: float = LINGER) -> None:
        self.guard = guard
        self._node = node
        self._linger = linger
        self._lock = threading.Lock()
        self._leaving: dict[Publisher, threading.Timer] = {}
        self._open: set[Publisher] = set()
        self._closed = False

    def open(
        self,
        client: Hashable,
        topic: str,
        type: type[Message] | str,
        *,
        latch: bool = False,
        queue_size: int = 100,
    ) -> Publication:
        """Publish a topic for a client. Asks the master.

        Raises:
            DefinitionError: No such type is known.
            LocalProtocolError: The topic is published here with another type, or this is closed.
            MasterError, ConnectionLost, RosTimeout: It could not be registered.
        """
        if self._closed:
            raise LocalProtocolError(f"{topic}: the gateway is closed")
        name = type if isinstance(type, str) else type._type
        velocity = is_velocity(name)
        publisher = self._node.publisher(
            topic,
            type,
            latch=latch,
            queue_size=LATE_VELOCITIES if velocity else max(1, queue_size),
            linger=not velocity,
        )
        with self._lock:
            if not self._closed:
                self._open.add(publisher)
                return Publication(self, client, publisher)
        publisher.close()
        raise LocalProtocolError(f"{topic}: the gateway is closed")

    def closed(self, publication: Publication, publisher: Publisher) -> None:
        """A handle was closed."""
        self.guard.gone(publication.client, publication.topic)
        with self._lock:
            if self._closed or publisher not in self._open:
                return
            timer = threading.Timer(self._linger, self._leave, (publisher,))
            timer.daemon = True
            timer.name = f"rosproto:leave {publication.topic}"
            self._leaving[publisher] = timer
            timer.start()

    def _leave(self, publisher: Publisher) -> None:
        with self._lock:
            self._leaving.pop(publisher, None)
            self._open.discard(publisher)
        try:
            publisher.close()
        except Exception as error:  # the master is away: there is nobody to tell
            _log.debug("! %s: not taken off the master: %s", publisher.topic, error)

    def close(self) -> None:
        """End all of them, zeros first (half a second when somebody drives). Twice is fine."""
        self.guard.close()
        with self._lock:
            self._closed = True
            timers, self._leaving = list(self._leaving.values()), {}
            publishers, self._open = list(self._open), set()
        for timer in timers:
            timer.cancel()
        for publisher in publishers:
            try:
                publisher.close()
            except Exception as error:
                _log.debug("! %s: not taken off the master: %s", publisher.topic, error)
