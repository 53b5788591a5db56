"""What clients publish: judged, decoded with the definition they name, and published by the node."""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import TYPE_CHECKING, Any

from rosproto.codec import Message, decode, define, message_class
from rosproto.errors import CodecError, DefinitionError, LocalProtocolError
from rosproto.gateway.access import Access
from rosproto.gateway.limits import GatewayLimits
from rosproto.gateway.publications import Publication, Publications
from rosproto.gateway.write_guard import is_velocity

if TYPE_CHECKING:
    from rosproto.node import Node

__all__ = ["ClientTopics", "Refused"]

ENCODING = "ros1"


class Refused(Exception):
    """What a client asked is not done; the text is a sentence for it."""


class ClientTopics:
    """The topics that clients of one server publish.

    Args:
        node: Knows names and definitions.
        access: Which topics are open.
        limits: Bounds.
        publications: Publish them.
    """

    def __init__(self, node: Node, access: Access, limits: GatewayLimits, publications: Publications) -> None:
        self._node = node
        self._access = access
        self._limits = limits
        self._publications = publications

    def advertise(self, client: Hashable, channel: Any) -> Publication:
        """Open what a client wants to publish. Asks the master.

        Args:
            client: Who.
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
            raise Refused(
                f"publishing on {topic} is refused: it comes as {channel.encoding[:40]}, not {ENCODING}"
            )
        try:
            return self._publications.open(client, topic, self._kind(topic, channel))
        except LocalProtocolError as problem:
            raise Refused(str(problem)) from None

    def _kind(self, topic: str, channel: Any) -> type[Message]:
        """Our class of that name when the client means the same, else one made from its text."""
        name, text = channel.schema_name, (channel.schema or b"").decode("utf-8", "replace")
        known: type[Message] | None = None
        try:
            known = message_class(name, self._node.revisions.library_for(name))
        except (DefinitionError, ValueError):
            pass
        if not text.strip():
            if known is None:
                raise Refused(
                    f"publishing on {topic} is refused: no definition of {name[:200]} is known here"
                )
            return known
        try:
            told = define(name, text)
        except (DefinitionError, CodecError, ValueError) as problem:
            if known is not None:
                return known  # a viewer's own spelling of a well-known type; the bytes will show
            raise Refused(
                f"publishing on {topic} is refused: its definition cannot be used: {problem}"
            ) from None
        return known if known is not None and known._md5sum == told._md5sum else told

    def publish(self, publication: Publication, data: bytes) -> None:
        """One message.

        Raises:
            Refused: It is no such message, or a velocity that is no number.
            RosError: It could not be published.
        """
        topic = publication.topic
        if len(data) > self._limits.message_bytes:
            raise Refused(f"a message for {topic} has {len(data)} bytes, which is too large")
        try:
            message = decode(publication.message_class, data)
        except CodecError as problem:
            raise Refused(f"a message for {topic} is not published: {problem}") from None
        if is_velocity(publication.type_name) and not finite(message):
            raise Refused(f"a velocity for {topic} is not published: it has numbers that are not finite")
        publication.publish(message)


def finite(message: Any) -> bool:
    """Whether every number in a message is one."""
    for name in message.__slots__:
        value = getattr(message, name)
        if isinstance(value, Message):
            if not finite(value):
                return False
        elif isinstance(value, float) and not math.isfinite(value):
            return False
    return True
