"""Messages that clients publish: checked, decoded with the definition they name, published by the node.

They come as `ros1` (ROS's own bytes) or as `json`, an object by field with times as {"sec", "nsec"}. Viewers
use JSON for what a person typed or steered, also where they have no definition of the type.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING

from rosproto.codec import Message, decode, define, message_class
from rosproto.errors import CodecError, DefinitionError, LocalProtocolError
from rosproto.gateway.access import Access
from rosproto.gateway.foxglove.messages import ENCODINGS, SCHEMA_ENCODING, ClientChannel
from rosproto.gateway.json_text import JsonError, JsonReader
from rosproto.gateway.limits import GatewayLimits
from rosproto.gateway.publications import Publication, Publications
from rosproto.gateway.rosbridge.actions import definition_name
from rosproto.gateway.rosbridge.values import from_values

if TYPE_CHECKING:
    from rosproto.node import Node


class Refused(Exception):
    """A client's request is refused; the text is the sentence that it gets."""


class NotOpen(Refused):
    """No pattern opens the topic. Told when the client publishes: viewers advertise unasked."""


class Advert:
    """A topic that one client publishes on one of its channels. Close it at the end.

    Args:
        publication: The node's.
        encoding: One of `ENCODINGS`.
    """

    __slots__ = ("encoding", "publication")

    def __init__(self, publication: Publication, encoding: str) -> None:
        self.publication = publication
        self.encoding = encoding

    def close(self) -> None:
        """Stop publishing it."""
        self.publication.close()


class ClientTopics:
    """The topics that clients of one server publish.

    Args:
        node: Resolves names, and knows definitions.
        access: Which topics may be published.
        limits: Bounds.
        publications: The node's publishers for clients.
        json: Reads what comes as JSON.
    """

    def __init__(
        self,
        node: Node,
        access: Access,
        limits: GatewayLimits,
        publications: Publications,
        json: JsonReader,
    ) -> None:
        self._node = node
        self._access = access
        self._limits = limits
        self._publications = publications
        self._json = json

    def advertise(self, client: Hashable, channel: ClientChannel) -> Advert:
        """Open a topic that a client wants to publish. Asks the master.

        Args:
            client: Stands for the client.
            channel: What it says of it.

        Raises:
            NotOpen: No pattern opens the topic.
            Refused: It may not be published in this way.
            RosError: The master refuses the registration.
        """
        if max(len(channel.topic), len(channel.schema_name)) > self._limits.text_length:
            raise Refused("the name of a topic or type is too long")
        try:
            topic = self._node.resolve_name(channel.topic)
        except ValueError as problem:
            raise Refused(str(problem)) from None
        name = definition_name(channel.schema_name)
        refusal = self._access.may_write("topic", topic, name)
        if refusal is not None:
            raise NotOpen(refusal.text)
        if channel.encoding not in ENCODINGS:
            raise Refused(
                f"publishing on {topic} is refused: it comes as {channel.encoding[:40]!r}; "
                f"expected {' or '.join(ENCODINGS)}"
            )
        try:
            publication = self._publications.open(client, topic, self._kind(topic, name, channel))
        except LocalProtocolError as problem:
            raise Refused(str(problem)) from None
        return Advert(publication, channel.encoding)

    def _kind(self, topic: str, name: str, channel: ClientChannel) -> type[Message]:
        """The class known here if the client means the same type, else one made from its definition."""
        text = channel.schema if channel.schema_encoding in ("", SCHEMA_ENCODING) else ""
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
                return known  # a viewer's own spelling of a known type: decoding shows whether the bytes fit
            raise Refused(
                f"publishing on {topic} is refused: its definition cannot be used: {problem}"
            ) from None
        return known if known is not None and known._md5sum == told._md5sum else told

    def publish(self, advert: Advert, data: bytes) -> None:
        """Publish a message.

        Raises:
            Refused: The bytes do not fit the type.
            RosError: It could not be published, or is a velocity that is not finite.
        """
        publication = advert.publication
        topic = publication.topic
        try:
            if advert.encoding == "json":
                values = self._json.read(data)
                if not values:
                    raise JsonError("is empty; expected JSON")
                message = from_values(
                    publication.message_class, values[0], now=self._node.clock.now(), seconds="sec"
                )
            else:
                message = decode(publication.message_class, data)
        except JsonError as problem:
            raise Refused(f"a message for {topic} is not published: it {problem}") from None
        except CodecError as problem:
            raise Refused(f"a message for {topic} is not published: {problem}") from None
        publication.publish(message)
