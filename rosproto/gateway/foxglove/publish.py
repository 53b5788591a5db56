"""What clients publish: checked, decoded with the definition they name, and published by the node.

All clients of a server share one publisher of a topic. It outlives its last client a little, for the zeros that
`WriteGuard` sends after a client that drove.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Hashable
from typing import TYPE_CHECKING, Any

from rosproto.codec import Message, decode, define, message_class
from rosproto.errors import CodecError, DefinitionError, LocalProtocolError
from rosproto.gateway.access import Access
from rosproto.gateway.limits import GatewayLimits
from rosproto.gateway.write_guard import WriteGuard, is_velocity

if TYPE_CHECKING:
    from rosproto.node import Node, Publisher

__all__ = ["Advert", "Publications", "Refused"]

KEPT_SECONDS = 3.0
ENCODING = "ros1"


class Refused(Exception):
    """What a client asked is not done; the text is a sentence for it."""


class Advert:
    """One topic that one client publishes.

    Attributes:
        topic: Resolved name.
        kind: Class of its messages.
        publisher: Shared with other clients.
        messages: Published so far.
    """

    def __init__(self, topic: str, kind: type[Message], publisher: Publisher) -> None:
        self.topic = topic
        self.kind = kind
        self.publisher = publisher
        self.messages = 0


class _Shared:
    def __init__(self, publisher: Publisher) -> None:
        self.publisher = publisher
        self.users = 0
        self.left = 0.0  # when the last one left


class Publications:
    """The publishers of one server.

    Args:
        node: Publishes.
        access: Which topics.
        limits: Bounds.
        guard: Sends zeros after those who drove.
    """

    def __init__(self, node: Node, access: Access, limits: GatewayLimits, guard: WriteGuard) -> None:
        self._node = node
        self._access = access
        self._limits = limits
        self.guard = guard
        self._lock = threading.Lock()
        self._shared: dict[str, _Shared] = {}
        self._closed = False

    @property
    def topics(self) -> tuple[str, ...]:
        """Topics with a publisher now."""
        with self._lock:
            return tuple(self._shared)

    def advertise(self, channel: Any) -> Advert:
        """Open it for one client. Asks the master.

        Args:
            channel: The SDK's `ClientChannel`.

        Raises:
            Refused: It may not be published, or not like this.
            RosError: The master does not take it.
        """
        if max(len(channel.topic), len(channel.schema_name)) > self._limits.text_length:
            raise Refused("the name of a topic or type is too long")
        try:
            topic = self._node.resolve_name(channel.topic)
        except ValueError as problem:
            raise Refused(str(problem)) from None
        refusal = self._access.may_write("topic", topic, channel.schema_name)
        if refusal is not None:
            raise Refused(refusal.text)
        if channel.encoding != ENCODING:
            raise Refused(f"publishing on {topic} is refused: it comes as {channel.encoding}, not {ENCODING}")
        kind = self._kind(topic, channel)
        with self._lock:
            if self._closed:
                raise Refused("the server is closing")
            shared = self._shared.get(topic)
            if shared is None or shared.publisher.closed:
                try:
                    shared = _Shared(self._node.publisher(topic, kind))
                except LocalProtocolError as problem:
                    raise Refused(str(problem)) from None
                self._shared[topic] = shared
            elif shared.publisher.md5sum != kind._md5sum:
                raise Refused(
                    f"publishing on {topic} is refused: another client publishes"
                    f" {shared.publisher.type_name} there with another definition"
                )
            shared.users += 1
        return Advert(topic, kind, shared.publisher)

    def _kind(self, topic: str, channel: Any) -> type[Message]:
        """Our class of that name when the client means the same, else one made from its text."""
        name, text = channel.schema_name, (channel.schema or b"").decode("utf-8", "replace")
        try:
            known = message_class(name, self._node.revisions.library_for(name))
        except (DefinitionError, ValueError):
            known = None
        if not text.strip():
            if known is None:
                raise Refused(f"publishing on {topic} is refused: no definition of {name[:200]} is known here")
            return known
        try:
            told = define(name, text)
        except (DefinitionError, CodecError, ValueError) as problem:
            if known is not None:
                return known  # a viewer's own spelling of a well-known type
            raise Refused(f"publishing on {topic} is refused: its definition cannot be used: {problem}") from None
        return known if known is not None and known._md5sum == told._md5sum else told

    def publish(self, client: Hashable, advert: Advert, data: bytes) -> None:
        """One message.

        Raises:
            Refused: It is no such message, or a velocity that is no number.
            RosError: It could not be published.
        """
        if len(data) > self._limits.message_bytes:
            raise Refused(f"a message for {advert.topic} has {len(data)} bytes, which is too large")
        try:
            message = decode(advert.publisher.message_class, data)
        except CodecError as problem:
            raise Refused(f"a message for {advert.topic} is not published: {problem}") from None
        if is_velocity(advert.kind._type) and not _finite(message):
            raise Refused(f"a velocity for {advert.topic} is not published: it has numbers that are not finite")
        self.guard.publish(client, advert.publisher, message)
        advert.messages += 1

    def leave(self, client: Hashable, advert: Advert) -> None:
        """A client publishes it no more."""
        self.guard.gone(client, advert.topic)
        with self._lock:
            shared = self._shared.get(advert.topic)
            if shared is not None and shared.publisher is advert.publisher:
                shared.users -= 1
                shared.left = time.monotonic()

    def tidy(self) -> None:
        """Close publishers that nobody has used for a while; called from time to time. Asks the master."""
        now = time.monotonic()
        with self._lock:
            over = [
                topic
                for topic, shared in self._shared.items()
                if shared.users <= 0 and now - shared.left > KEPT_SECONDS
            ]
            publishers = [self._shared.pop(topic).publisher for topic in over]
        for publisher in publishers:
            publisher.close()

    def close(self) -> None:
        """Zeros, then all publishers."""
        self.guard.close()
        with self._lock:
            self._closed = True
            publishers = [shared.publisher for shared in self._shared.values()]
            self._shared.clear()
        for publisher in publishers:
            publisher.close()


def _finite(message: Any) -> bool:
    for name in message.__slots__:
        value = getattr(message, name)
        if isinstance(value, Message):
            if not _finite(value):
                return False
        elif isinstance(value, float) and not math.isfinite(value):
            return False
    return True
