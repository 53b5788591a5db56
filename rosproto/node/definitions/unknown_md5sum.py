"""A subscriber's md5sum that nobody here knows: other publishers of the topic are asked for the definition.

A rospy subscriber sends its definition, a roscpp one does not. But on a chassis the action servers have a
client of their own (`/ros_interface` publishes their goal topics), and every publisher sends its definition:
the one with the subscriber's md5sum is the one that is missing.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rosproto.codec import Message
from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.node.definitions.topic_probe import probe_topic
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from rosproto.node.graph.caller_identity import CallerIdentity

_log = get_logger("rosproto.node")

FETCH_SECONDS = 3.0  # the subscriber waits for our answer meanwhile
MOST_ASKED = 8
AGAIN_AFTER = 10.0  # seconds; a stranger who connects again and again must not make us busy
MOST_REMEMBERED = 200


Learn = Callable[["type[Message]", str, str], "type[Message] | None"]
"""`KnownDefinitions.learn`: the class of a type by md5sum and full definition; None if they do not agree."""


class DefinitionLookup:
    """What was asked of other publishers, for one node; safe from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._asked: dict[tuple[str, str], float] = {}

    def fetch(
        self, caller: CallerIdentity, learn: Learn, topic: str, ours: type[Message], md5sum: str
    ) -> type[Message] | None:
        """The class of `ours`' type with that md5sum, by another publisher's word; None when nobody has it.

        `learn` makes a class of a definition that was found (`KnownDefinitions.learn`).

        Waits at most `FETCH_SECONDS`; a question without an answer is not repeated for `AGAIN_AFTER` seconds.
        """
        if not self._may_ask(topic, md5sum):
            return None
        deadline = Deadline(FETCH_SECONDS)
        try:
            publishers = caller.master.get_system_state(timeout=deadline.remaining()).publishers.get(
                topic, []
            )
        except (RosError, OSError) as error:
            _log.debug("! %s: nobody can be asked for a definition: %s", topic, error)
            return None
        for publisher in [name for name in publishers if name != caller.name][:MOST_ASKED]:
            try:
                reply = probe_topic(caller, topic, publisher, deadline)
            except (RosError, OSError) as error:
                _log.debug("! %s: %s does not tell its definition: %s", topic, publisher, error)
                continue
            if reply.md5sum == md5sum and reply.type_name == ours._type:
                found = learn(ours, md5sum, reply.message_definition)
                if found is not None:
                    _log.info("= %s: the definition %s was learned from %s", topic, md5sum, publisher)
                    return found
        return None

    def _may_ask(self, topic: str, md5sum: str) -> bool:
        now = time.monotonic()
        with self._lock:
            if now - self._asked.get((topic, md5sum), -AGAIN_AFTER) < AGAIN_AFTER:
                return False
            if len(self._asked) >= MOST_REMEMBERED:
                recent = {key: when for key, when in self._asked.items() if now - when < AGAIN_AFTER}
                if len(recent) >= MOST_REMEMBERED:
                    return False
                self._asked = recent
            self._asked[topic, md5sum] = now
            return True
