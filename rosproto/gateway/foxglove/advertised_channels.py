"""`AdvertisedChannels`: the channels (topics with their schemas) and services advertised to viewers.

A channel costs the robot nothing until a viewer subscribes to it, but needs a schema before: type and
definition text. The master knows only the name of the type. The text is the one that a publisher has sent,
else the known definition; for an unknown type a publisher is probed. If the first message shows that the
robot uses another revision, the topic is advertised again with the publisher's definition.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from itertools import count
from typing import NamedTuple

from rosproto.codec import ServiceType, message_class
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
RETRY_SECONDS = 15.0  # until failed probes of a topic are repeated
MAX_PROBES = 3  # publishers of one topic probed at a time


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
    """A topic as advertised to viewers; with another schema it is another channel.

    Attributes:
        id: Channel id.
        topic: Name of the topic.
        schema: Its type.
    """

    id: int
    topic: str
    schema: TopicSchema


class AdvertisedService(NamedTuple):
    """A service whose type is known, as advertised to viewers.

    Attributes:
        id: Service id.
        name: Name of the service.
        kind: Its class.
    """

    id: int
    name: str
    kind: type[ServiceType]


class AdvertisedChannels:
    """The channels and services of one server, with the same ids for all viewers.

    Args:
        node: Probes publishers, and knows definitions.
        access: What viewers may see.
        topics: Topics of this program.
    """

    def __init__(self, node: Node, access: Access, topics: Iterable[LocalTopic]) -> None:
        self._access = access
        self._node = node
        self._topics = tuple(topics)
        self._lock = threading.Lock()
        self._numbers = count(1)
        self._view: GraphView | None = None
        self._channels: dict[str, AdvertisedChannel] = {}
        self._services: dict[str, AdvertisedService] = {}
        self._schemas: dict[str, TopicSchema] = {}
        self._retry_at: dict[tuple[str, str], float] = {}

    def channels(self, view: GraphView) -> Mapping[str, AdvertisedChannel]:
        """The visible topics of a view, and this program's own. May probe publishers."""
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
            and self._access.shows("topic", topic)
            and (schema := self._schema(topic, kind, view.state.publishers[topic]))
        }
        for name, description in local.items():
            if self._access.shows("topic", name):
                found[name] = TopicSchema(description.type_name, description.md5sum, description.definition)
        return found

    def _schema(self, topic: str, type_name: str, publishers: Sequence[str]) -> TopicSchema | None:
        """The schema of a topic; None if unknown. May probe publishers, for some seconds."""
        schema = self._schemas.get(topic)
        if schema is not None and schema.type_name == type_name:
            return schema
        try:
            known = message_class(type_name, self._node.definitions.library_for(type_name))
            return TopicSchema(type_name, known._md5sum, known._full_text)
        except (DefinitionError, ValueError):
            return self._ask(topic, type_name, publishers)

    def _ask(self, topic: str, type_name: str, publishers: Sequence[str]) -> TopicSchema | None:
        now = time.monotonic()
        if now < self._retry_at.get((topic, type_name), 0.0):
            return None
        for publisher in publishers[:MAX_PROBES]:
            try:
                header = probe_topic(self._node, topic, publisher, Deadline(PROBE_SECONDS))
            except (RosError, OSError) as problem:
                _log.info("! %s: %s has not sent its type: %s", topic, publisher, problem)
                continue
            if header.message_definition and header.type_name == type_name:
                schema = TopicSchema(type_name, header.md5sum, header.message_definition)
                self._schemas[topic] = schema
                return schema
        self._retry_at[topic, type_name] = now + RETRY_SECONDS
        return None

    def services(self, present: Mapping[str, type[ServiceType]]) -> Mapping[str, AdvertisedService]:
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
        """Keep the schema that a publisher has sent; False if it sent no definition."""
        if not description.definition:
            return False
        schema = TopicSchema(description.type_name, description.md5sum, description.definition)
        with self._lock:
            self._schemas[description.topic] = schema
            self._view = None
        return True

    def keep_only(self, present: set[str]) -> None:
        """Forget the schemas of all topics but these."""
        with self._lock:
            self._schemas = {topic: schema for topic, schema in self._schemas.items() if topic in present}
            self._retry_at = {key: when for key, when in self._retry_at.items() if key[0] in present}
