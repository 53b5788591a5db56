"""Publishes the messages of viewers: checks them and decodes them by their definition.

They are encoded as `ros1` (serialized) or `json` (an object by field, times as {"sec", "nsec"}). Viewers use
JSON for typed and steered messages, also for types whose definition they do not have.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Hashable
from functools import partial
from typing import NamedTuple, Protocol

from rosproto.codec import Message, decode, define, message_class
from rosproto.errors import CodecError, DefinitionError, LocalProtocolError, RosError
from rosproto.gateway.access import Access, Refused
from rosproto.gateway.client_channel import ClientChannel
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.client_publications import ClientPublication, ClientPublications
from rosproto.gateway.foxglove.messages import (
    ENCODINGS,
    SCHEMA_ENCODING,
    Advertise,
    ClientAdvertisement,
    Publish,
    Unadvertise,
)
from rosproto.gateway.json_text import JsonError, JsonReader, is_short
from rosproto.gateway.values import definition_name, from_values
from rosproto.gateway.velocity_watchdog import is_velocity
from rosproto.node import Node


class NotWritable(Refused):
    """No pattern opens the topic. Reported when the client publishes, as viewers advertise by themselves."""


class AdvertisedTopic(NamedTuple):
    """A topic that one client publishes on one of its channels.

    Attributes:
        publication: Closed at the end.
        encoding: One of `ENCODINGS`.
    """

    publication: ClientPublication
    encoding: str


class ClientTopics:
    """The topics that clients of one server publish.

    Args:
        node: Resolves names, and knows definitions.
        access: Which topics may be published.
        limits: Bounds.
        publications: The publishers for clients.
        json: Decodes JSON.

    Attributes:
        refusals: Number of refused requests.
        most: Most channels of one client.
    """

    def __init__(
        self,
        node: Node,
        access: Access,
        limits: GatewayLimits,
        publications: ClientPublications,
        json: JsonReader,
    ) -> None:
        self._node = node
        self._access = access
        self._limits = limits
        self._publications = publications
        self._json = json
        self.refusals = 0
        self.most = limits.advertised_per_client

    def advertise(self, client: Hashable, channel: ClientAdvertisement) -> AdvertisedTopic:
        """Open a topic that a client wants to publish. Calls the master.

        Args:
            client: The client.
            channel: Its advertisement.

        Raises:
            NotWritable: No pattern opens the topic.
            Refused: The advertisement is not valid.
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
            raise NotWritable(refusal.text)
        if channel.encoding not in ENCODINGS:
            raise Refused(
                f"publishing on {topic} is refused: it comes as {channel.encoding[:40]!r}; "
                f"expected {' or '.join(ENCODINGS)}"
            )
        try:
            publication = self._publications.open(client, topic, self._kind(topic, name, channel))
        except LocalProtocolError as problem:
            raise Refused(str(problem)) from None
        return AdvertisedTopic(publication, channel.encoding)

    def _kind(self, topic: str, name: str, channel: ClientAdvertisement) -> type[Message]:
        """The known class if the client means the same type, else one made from its definition."""
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
            given = define(name, text)
        except (DefinitionError, CodecError, ValueError) as problem:
            if known is not None:
                return known  # a viewer's own format of a known type: decoding checks the bytes
            raise Refused(
                f"publishing on {topic} is refused: its definition cannot be used: {problem}"
            ) from None
        return known if known is not None and known._md5sum == given._md5sum else given

    def publish(self, advertised: AdvertisedTopic, data: bytes) -> None:
        """Publish a message.

        Raises:
            Refused: The bytes do not fit the type.
            RosError: It could not be published, or is a velocity that is not finite.
        """
        publication = advertised.publication
        topic = publication.topic
        try:
            if advertised.encoding == "json":
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


class PublishingViewer(Protocol):
    """A session, as `ClientPublisher` uses it; it is also the client of `VelocityWatchdog`."""

    channel: ClientChannel

    def __hash__(self) -> int: ...
    def status(self, text: str) -> None: ...


class ClientPublisher:
    """Publishes for one client, in the order of its requests. Only `publish` may wait.

    Args:
        topics: The topics of all clients.
        viewer: The client's session.
        queue: Queues work that may wait for the robot.

    Attributes:
        published: Number of messages so far.
    """

    def __init__(
        self, topics: ClientTopics, viewer: PublishingViewer, queue: Callable[[Callable[[], None]], None]
    ) -> None:
        self.published = 0
        self._topics = topics
        self._viewer = viewer
        self._queue = queue
        self._lock = threading.Lock()
        self._advertised: dict[int, AdvertisedTopic | str] = {}  # a text: the refusal
        self._behind: Counter[int] = Counter()  # queued work of each channel
        self._closed = False

    def advertise(self, asked: Advertise) -> None:
        """The client advertises channels."""
        for channel in asked.channels:
            self._put_behind(channel.id, partial(self._advertise, channel))

    def unadvertise(self, asked: Unadvertise) -> None:
        """The client ends channels."""
        for id in asked.channels:
            self._put_behind(id, partial(self._unadvertise, id))

    def publish_at_once(self, asked: Publish) -> bool:
        """Publish a short message now, or queue it behind its channel's work; False: call `publish`."""
        with self._lock:
            behind = asked.channel in self._behind
        if behind:
            self._put_behind(asked.channel, partial(self.publish, asked))
        elif is_short(asked.data):
            self.publish(asked)
        else:
            return False
        return True

    def _put_behind(self, channel: int, work: Callable[[], None]) -> None:
        """Queue work of a channel; later messages of the channel wait for it."""

        def do() -> None:
            try:
                work()
            finally:
                with self._lock:
                    self._behind[channel] -= 1
                    if not self._behind[channel]:
                        del self._behind[channel]

        with self._lock:
            self._behind[channel] += 1
        self._queue(do)

    def _advertise(self, channel: ClientAdvertisement) -> None:
        opened: AdvertisedTopic | str
        try:
            if channel.id in self._advertised:
                raise Refused(f"channel {channel.id} is advertised already")
            if len(self._advertised) >= self._topics.most:
                raise Refused(f"{self._topics.most} topics are published, which is the limit for a client")
            opened = self._topics.advertise(self._viewer, channel)
        except NotWritable as problem:
            opened = str(problem)
        except (Refused, RosError) as problem:
            self._topics.refusals += 1
            self._viewer.status(str(problem))
            return
        with self._lock:
            closed = self._closed
            if not closed:
                self._advertised[channel.id] = opened
        if closed and isinstance(opened, AdvertisedTopic):
            opened.publication.close()

    def _unadvertise(self, id: int) -> None:
        with self._lock:
            advertised = self._advertised.pop(id, None)
        if isinstance(advertised, AdvertisedTopic):
            advertised.publication.close()

    def publish(self, asked: Publish) -> None:
        """Publish a message; errors are reported to the client."""
        with self._lock:
            advertised = self._advertised.get(asked.channel)
        connection = self._viewer.channel
        if self._closed or connection.lost:
            return
        if advertised is None:
            self._viewer.status(f"nothing is published: channel {asked.channel} is not advertised")
        elif isinstance(advertised, str):
            self._topics.refusals += 1
            self._viewer.status(advertised)
        elif not (connection.gone and is_velocity(advertised.publication.type_name)):
            # A velocity whose client has gone in the meantime is not published.
            try:
                self._topics.publish(advertised, asked.data)
                self.published += 1
            except (Refused, RosError) as problem:
                self._viewer.status(str(problem))

    def close(self) -> None:
        """Stop publishing."""
        with self._lock:
            self._closed = True
            advertised_topics = list(self._advertised.values())
            self._advertised.clear()
        for advertised in advertised_topics:
            if isinstance(advertised, AdvertisedTopic):
                advertised.publication.close()
