"""What viewers are offered: channels, which are topics with their schemas, and services.

A channel costs the robot nothing until a viewer subscribes it. A viewer needs the schema before that: type
and definition text. The master knows only the name of the type. The text comes from a publisher that has
sent it, otherwise from the definitions at hand; for a type that is not known here, a publisher is asked. If
the first message shows that the robot uses another revision, the topic is offered again with the publisher's
definition.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from itertools import count
from typing import Any, NamedTuple

from rosproto.codec import message_class
from rosproto.errors import DefinitionError, RosError
from rosproto.gateway.access import Access
from rosproto.gateway.foxglove.graph import GraphView
from rosproto.gateway.local_topic import LocalTopic
from rosproto.gateway.message_event import TopicDescription
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.node.definitions.topic_probe import probe_topic
from rosproto.transport.deadline import Deadline

_log = get_logger("rosproto.gateway")

PROBE_SECONDS = 2.0
RETRY_SECONDS = 15.0  # until a publisher that could not be asked is asked again
MAX_PROBES = 3  # publishers of one topic that are asked at a time


class TopicSchema(NamedTuple):
    """A topic's type.

    Attributes:
        type_name: "package/Type".
        md5sum: Of the definition.
        definition: Full text.
    """

    type_name: str
    md5sum: str
    definition: str


class AdvertisedChannel(NamedTuple):
    """A topic as viewers are offered it; with another schema it is another channel.

    Attributes:
        id: Its number at this server.
        topic: Its name.
        schema: Its type.
    """

    id: int
    topic: str
    schema: TopicSchema


class AdvertisedService(NamedTuple):
    """A service whose type is known.

    Attributes:
        id: Its number at this server.
        name: Its name.
        kind: Its class.
    """

    id: int
    name: str
    kind: Any


class AdvertisedChannels:
    """The channels and services of one server, with numbers that are the same for all viewers.

    Args:
        node: Asks publishers, and knows definitions.
        access: What viewers may see.
        topics: Topics of this program.
    """

    def __init__(self, node: Node, access: Access, topics: Iterable[LocalTopic]) -> None:
        self._access = access
        self._topics = tuple(topics)
        self._schemas = _TopicSchemas(node)
        self._lock = threading.Lock()
        self._numbers = count(1)
        self._view: GraphView | None = None
        self._channels: dict[str, AdvertisedChannel] = {}
        self._services: dict[str, AdvertisedService] = {}

    def channels(self, view: GraphView) -> Mapping[str, AdvertisedChannel]:
        """The topics of a view that viewers may see, and this program's own. May ask publishers."""
        with self._lock:
            if self._view is not view:
                before = self._channels
                self._channels = {
                    topic: known
                    if (known := before.get(topic)) is not None and known.schema == schema
                    else AdvertisedChannel(next(self._numbers), topic, schema)
                    for topic, schema in self._found(view).items()
                }
                self._view = view
            return self._channels

    def _found(self, view: GraphView) -> dict[str, TopicSchema]:
        local = {topic.name: topic.description for topic in self._topics}
        found = {
            topic: schema
            for topic, kind in view.types.items()
            if topic not in local
            and self._access.may_read("topic", topic) is None
            and (schema := self._schemas.schema(topic, kind, view.state.publishers[topic]))
        }
        for name, told in local.items():
            if self._access.may_read("topic", name) is None:
                found[name] = TopicSchema(told.type_name, told.md5sum, told.definition)
        return found

    def services(self, present: Mapping[str, Any]) -> Mapping[str, AdvertisedService]:
        """Services by name, from their classes."""
        with self._lock:
            before = self._services
            self._services = {
                name: known
                if (known := before.get(name)) is not None and known.kind is kind
                else AdvertisedService(next(self._numbers), name, kind)
                for name, kind in present.items()
            }
            return self._services

    def learn(self, description: TopicDescription) -> bool:
        """Keep what a publisher has sent of its topic; False when it sent no definition."""
        if not description.definition:
            return False
        self._schemas.learn(description)
        with self._lock:
            self._view = None
        return True

    def keep_only(self, present: set[str]) -> None:
        """Forget the schemas of all topics but these."""
        self._schemas.keep_only(present)


class _TopicSchemas:
    """The schemas of all topics, for the clients of one server.

    Args:
        node: Asks publishers, and knows definitions.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._known: dict[str, TopicSchema] = {}
        self._retry_at: dict[tuple[str, str], float] = {}

    def learn(self, description: TopicDescription) -> None:
        heard = TopicSchema(description.type_name, description.md5sum, description.definition)
        with self._lock:
            self._known[description.topic] = heard

    def schema(self, topic: str, type_name: str, publishers: Sequence[str]) -> TopicSchema | None:
        """The schema of a topic; None if it cannot be found out. May ask a publisher, for some seconds."""
        with self._lock:
            heard = self._known.get(topic)
        if heard is not None and heard.type_name == type_name:
            return heard
        try:
            known = message_class(type_name, self._node.revisions.library_for(type_name))
            return TopicSchema(type_name, known._md5sum, known._full_text)
        except (DefinitionError, ValueError):
            return self._ask(topic, type_name, publishers)

    def _ask(self, topic: str, type_name: str, publishers: Sequence[str]) -> TopicSchema | None:
        now = time.monotonic()
        if now < self._retry_at.get((topic, type_name), 0.0):
            return None
        for publisher in publishers[:MAX_PROBES]:
            try:
                probed = probe_topic(self._node, topic, publisher, Deadline(PROBE_SECONDS))
            except (RosError, OSError) as problem:
                _log.info("! %s: %s does not tell its type: %s", topic, publisher, problem)
                continue
            if probed.message_definition and probed.type_name == type_name:
                heard = TopicSchema(type_name, probed.md5sum, probed.message_definition)
                with self._lock:
                    self._known[topic] = heard
                return heard
        self._retry_at[topic, type_name] = now + RETRY_SECONDS
        return None

    def keep_only(self, present: set[str]) -> None:
        """Forget all topics but these."""
        with self._lock:
            self._known = {topic: heard for topic, heard in self._known.items() if topic in present}
            self._retry_at = {key: when for key, when in self._retry_at.items() if key[0] in present}
