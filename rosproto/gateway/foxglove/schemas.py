"""What is told of a topic before anybody subscribes it: its type and the text of its definition.

A viewer has to know both in order to offer the topic. The master knows the type's name alone. The text is the
one a publisher has sent, else that of the definition we have; for a type that we do not know a publisher is
asked. When the first message shows that the robot has another revision, the topic is announced again with
that.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rosproto.codec import message_class
from rosproto.errors import DefinitionError, RosError
from rosproto.logs import get_logger
from rosproto.node.revisions.topic_probe import probe_topic
from rosproto.records import NamedTuple
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from rosproto.gateway.message_event import TopicDescription
    from rosproto.node import Node

__all__ = ["Described", "TopicBook"]

_log = get_logger("rosproto.gateway")

PROBE_SECONDS = 2.0
AGAIN_AFTER = 15.0  # seconds until a publisher that could not be asked is asked again
PROBES = 3  # publishers of one topic that are asked in one look


class Described(NamedTuple):
    """A topic's type.

    Attributes:
        type_name: "package/Type".
        md5sum: Of the definition.
        definition: Full text.
    """

    type_name: str
    md5sum: str
    definition: str


class TopicBook:
    """The descriptions of topics, for all clients of one server.

    Args:
        node: Asks publishers, and knows definitions.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._heard: dict[str, Described] = {}
        self._in_vain: dict[tuple[str, str], float] = {}

    def note(self, description: TopicDescription) -> Described | None:
        """What a publisher has sent; None when that was no text."""
        if not description.definition:
            return None
        heard = Described(description.type_name, description.md5sum, description.definition)
        with self._lock:
            self._heard[description.topic] = heard
        return heard

    def describe(self, topic: str, type_name: str, publishers: Sequence[str]) -> Described | None:
        """What is known of a topic; may ask a publisher, which takes seconds at most. None: nothing yet."""
        with self._lock:
            heard = self._heard.get(topic)
        if heard is not None and heard.type_name == type_name:
            return heard
        try:
            known = message_class(type_name, self._node.revisions.library_for(type_name))
            return Described(type_name, known._md5sum, known._full_text)
        except (DefinitionError, ValueError):
            return self._asked(topic, type_name, publishers)

    def _asked(self, topic: str, type_name: str, publishers: Sequence[str]) -> Described | None:
        now = time.monotonic()
        if now < self._in_vain.get((topic, type_name), 0.0):
            return None
        for publisher in publishers[:PROBES]:
            try:
                said = probe_topic(self._node, topic, publisher, Deadline(PROBE_SECONDS))
            except (RosError, OSError) as problem:
                _log.info("! %s: %s does not tell its type: %s", topic, publisher, problem)
                continue
            if said.message_definition and said.type_name == type_name:
                heard = Described(type_name, said.md5sum, said.message_definition)
                with self._lock:
                    self._heard[topic] = heard
                return heard
        self._in_vain[topic, type_name] = now + AGAIN_AFTER
        return None

    def forget(self, present: set[str]) -> None:
        """Keep what was heard of these topics alone."""
        with self._lock:
            self._heard = {topic: heard for topic, heard in self._heard.items() if topic in present}
            self._in_vain = {key: when for key, when in self._in_vain.items() if key[0] in present}
