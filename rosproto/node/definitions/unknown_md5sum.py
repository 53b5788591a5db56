"""Look up a subscriber's unknown md5sum: ask the topic's other publishers for the definition.

A rospy subscriber sends its definition, a roscpp one does not. Every publisher sends its definition, and on
a chassis the goal topics of the action servers have another publisher (`/ros_interface`). If its md5sum is
the subscriber's, its definition is the missing one.
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
AGAIN_AFTER = 10.0  # seconds; limits the load of a peer that connects repeatedly
MOST_REMEMBERED = 200


Learn = Callable[["type[Message]", str, str], "type[Message] | None"]
"""`KnownDefinitions.learn`: the class of a type by md5sum and full definition; None if they do not agree."""


class DefinitionLookup:
    """Lookups at other publishers, for one node; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._asked: dict[tuple[str, str], float] = {}

    def fetch(
        self, caller: CallerIdentity, learn: Learn, topic: str, ours: type[Message], md5sum: str
    ) -> type[Message] | None:
        """The class of the type of `ours` with that md5sum, from another publisher; None if there is none.

        `learn` makes a class from a definition that was found (`KnownDefinitions.learn`).

        Waits at most `FETCH_SECONDS`; a failed lookup is not repeated for `AGAIN_AFTER` seconds.
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
