"""The schemas of topics: type and definition text, which a viewer needs before it can subscribe.

The master knows only the name of the type. The text comes from a publisher that has sent it, otherwise from
the definitions at hand; for a type that is not known here, a publisher is asked. If the first message shows
that the robot uses another revision, the topic is offered again with the publisher's definition.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from rosproto.codec import message_class
from rosproto.errors import DefinitionError, RosError
from rosproto.logs import get_logger
from rosproto.node.revisions.topic_probe import probe_topic
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from rosproto.gateway.message_event import TopicDescription
    from rosproto.node import Node

__all__ = ["TopicSchema", "TopicSchemas"]

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


class TopicSchemas:
    """The schemas of all topics, for the clients of one server.

    Args:
        node: Asks publishers, and knows definitions.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._known: dict[str, TopicSchema] = {}
        self._retry_at: dict[tuple[str, str], float] = {}

    def learn(self, description: TopicDescription) -> TopicSchema | None:
        """Keep what a publisher has sent; None when it sent no definition."""
        if not description.definition:
            return None
        heard = TopicSchema(description.type_name, description.md5sum, description.definition)
        with self._lock:
            self._known[description.topic] = heard
        return heard

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
                said = probe_topic(self._node, topic, publisher, Deadline(PROBE_SECONDS))
            except (RosError, OSError) as problem:
                _log.info("! %s: %s does not tell its type: %s", topic, publisher, problem)
                continue
            if said.message_definition and said.type_name == type_name:
                heard = TopicSchema(type_name, said.md5sum, said.message_definition)
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
