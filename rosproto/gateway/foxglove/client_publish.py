"""Publishes the messages of viewers: checks them and decodes them by their definition.

They are encoded as `ros1` (serialized) or `json` (an object by field, times as {"sec", "nsec"}). Viewers use
JSON for typed and steered messages, also for types whose definition they do not have.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from rosproto.codec import Message, decode, define, message_class
from rosproto.errors import CodecError, DefinitionError, LocalProtocolError, RosError
from rosproto.gateway.access import Refused
from rosproto.gateway.client_publications import ClientPublication
from rosproto.gateway.foxglove.messages import (
    ENCODINGS,
    SCHEMA_ENCODING,
    Advertise,
    ClientAdvertisement,
    Publish,
    Unadvertise,
)
from rosproto.gateway.foxglove.server_state import ServerState
from rosproto.gateway.values import definition_name, from_values
from rosproto.gateway.velocity_watchdog import is_velocity
from rosproto.json_text import JsonError, is_short

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.session import FoxgloveSession


class AdvertisedTopic(NamedTuple):
    """A topic that one client publishes on one of its channels.

    Attributes:
        publication: Closed at the end.
        encoding: One of `ENCODINGS`.
    """

    publication: ClientPublication
    encoding: str


class ClientPublisher:
    """Publishes for one client, in the order of its requests. Only `publish` may wait.

    Args:
        state: Shared by all sessions.
        viewer: The client's session; it is also the client of `VelocityWatchdog`.
        queue: Queues work that may wait for the robot.

    Attributes:
        published: Number of messages so far.
    """

    def __init__(
        self, state: ServerState, viewer: FoxgloveSession, queue: Callable[[Callable[[], None]], None]
    ) -> None:
        self.published = 0
        self._state = state
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
            self._put_behind(asked.channel, partial(self.publish, asked, time.monotonic()))
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
        limit = self._state.limits.advertised_per_client
        try:
            if channel.id in self._advertised:
                raise Refused(f"channel {channel.id} is already advertised")
            if len(self._advertised) >= limit:
                raise Refused(f"{limit} topics are published, which is the limit for a client")
            opened = self._open(channel)
        except (Refused, RosError) as problem:
            self._state.refusals += 1
            self._viewer.status(str(problem))
            return
        with self._lock:
            closed = self._closed
            if not closed:
                self._advertised[channel.id] = opened
        if closed and isinstance(opened, AdvertisedTopic):
            opened.publication.close()

    def _open(self, channel: ClientAdvertisement) -> AdvertisedTopic | str:
        """Open a topic that the client wants to publish. Calls the master.

        Returns:
            The topic; or why no pattern opens it, which is reported when the client publishes, as viewers
            advertise by themselves.

        Raises:
            Refused: The advertisement is not valid.
            RosError: The master refuses the registration.
        """
        state = self._state
        if max(len(channel.topic), len(channel.schema_name)) > state.limits.text_length:
            raise Refused("the name of a topic or type is too long")
        try:
            topic = state.node.resolve_name(channel.topic)
        except ValueError as problem:
            raise Refused(str(problem)) from None
        name = definition_name(channel.schema_name)
        refusal = state.access.may_write("topic", topic, name)
        if refusal is not None:
            return refusal.text
        if channel.encoding not in ENCODINGS:
            raise Refused(
                f"publishing on {topic} is refused: its encoding is {channel.encoding[:40]!r}; "
                f"expected {' or '.join(ENCODINGS)}"
            )
        try:
            publication = state.publications.open(self._viewer, topic, self._kind(topic, name, channel))
        except LocalProtocolError as problem:
            raise Refused(str(problem)) from None
        return AdvertisedTopic(publication, channel.encoding)

    def _kind(self, topic: str, name: str, channel: ClientAdvertisement) -> type[Message]:
        """The known class if the client means the same type, else one made from its definition."""
        text = channel.schema if channel.schema_encoding in ("", SCHEMA_ENCODING) else ""
        known: type[Message] | None = None
        try:
            known = message_class(name, self._state.node.definitions.library_for(name))
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

    def _unadvertise(self, id: int) -> None:
        with self._lock:
            advertised = self._advertised.pop(id, None)
        if isinstance(advertised, AdvertisedTopic):
            advertised.publication.close()

    def publish(self, asked: Publish, received: float | None = None) -> None:
        """Publish a message that came then (None: now); errors are reported to the client."""
        with self._lock:
            advertised = self._advertised.get(asked.channel)
        connection = self._viewer.channel
        if self._closed or connection.lost:
            return
        if advertised is None:
            self._viewer.status(f"nothing is published: channel {asked.channel} is not advertised")
        elif isinstance(advertised, str):
            self._state.refusals += 1
            self._viewer.status(advertised)
        elif not (connection.gone and is_velocity(advertised.publication.message_class)):
            # A velocity whose client has gone in the meantime is not published.
            try:
                advertised.publication.publish(self._message(advertised, asked.data), received)
                self.published += 1
            except (JsonError, CodecError) as problem:
                it = "it " if isinstance(problem, JsonError) else ""
                topic = advertised.publication.topic
                self._viewer.status(f"a message for {topic} is not published: {it}{problem}")
            except RosError as problem:
                self._viewer.status(str(problem))

    def _message(self, advertised: AdvertisedTopic, data: bytes) -> Message:
        """
        Raises:
            JsonError, CodecError: The bytes do not fit the type.
        """
        cls = advertised.publication.message_class
        if advertised.encoding != "json":
            return decode(cls, data)
        values = self._state.json.read(data)
        if not values:
            raise JsonError("is empty; expected JSON")
        return from_values(cls, values[0], now=self._state.node.clock.now(), seconds="sec")

    def close(self) -> None:
        """Stop publishing."""
        with self._lock:
            self._closed = True
            advertised_topics = list(self._advertised.values())
            self._advertised.clear()
        for advertised in advertised_topics:
            if isinstance(advertised, AdvertisedTopic):
                advertised.publication.close()
