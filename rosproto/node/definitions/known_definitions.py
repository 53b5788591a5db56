"""The definitions that one node knows: bundled, from the user's folders, and learned from peers.

Types given by name are looked up here, and definitions for md5sums other than ours.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterable
from typing import TypeVar

from rosproto.bounded_cache import BoundedCache
from rosproto.codec import Message, ServiceType, define, message_class, service_class
from rosproto.codec.binding import Binding
from rosproto.errors import CodecError, DefinitionError, RosError
from rosproto.logs import get_logger
from rosproto.msg import DefinitionLibrary, bundled
from rosproto.msg.user_folder import is_learned
from rosproto.node.definitions.topic_probe import probe_topic
from rosproto.node.graph.master_client import CallerIdentity
from rosproto.protocol.handshake import is_md5sum
from rosproto.transport.deadline import Deadline

_log = get_logger("rosproto.node")

MAX_FOUND = 1000
MAX_LEARNED = 64
MAX_LEARNED_CHARACTERS = 2 << 20  # total length of their texts

FETCH_SECONDS = 3.0  # the subscriber waits for our answer meanwhile
MAX_ASKED = 8  # publishers
AGAIN_AFTER = 10.0  # seconds; limits the load of a peer that connects repeatedly
MAX_REMEMBERED = 200


class KnownDefinitions:
    """The definitions one node knows in addition to those in use.

    Args:
        paths: Folders of .msg, .srv and .action files in ROS layout; a definition there is another revision
            of the bundled one, or a new type. `learned_paths` hold definitions that robots have sent.
    """

    def __init__(self, paths: Iterable[str | os.PathLike[str]] = ()) -> None:
        # Opened now: a folder that is not there is the caller's error, and not the first peer's.
        paths = list(paths)
        own = [path for path in paths if not is_learned(path)]
        self._learned_folders = [bundled().fork([path]) for path in paths if is_learned(path)]
        self._folders = [*(bundled().fork([path]) for path in own), *self._learned_folders]
        # The user's types mean what the user's folders together say: one may use a type of the next.
        self._own = None if not own else self._folders[0] if len(own) == 1 else bundled().fork(own)
        self._lock = threading.Lock()
        self._asked: dict[tuple[str, str], float] = {}  # (topic, md5sum) -> when its publishers were asked
        # Keyed by md5sums from peers. `define` has its own cache; `learn` shares a definition with all peers.
        # A tuple, so that a definition which was not found is remembered as (None,).
        self._found: BoundedCache[tuple[type, str], tuple[type[Message] | None]] = BoundedCache(MAX_FOUND)
        self._found_services: BoundedCache[tuple[type, str], tuple[type[ServiceType] | None]] = BoundedCache(
            MAX_FOUND
        )
        self._learned: BoundedCache[tuple[type, str], type[Message]] = BoundedCache(
            MAX_LEARNED, MAX_LEARNED_CHARACTERS
        )

    def library_for(self, name: str, kind: str = "msg") -> DefinitionLibrary | None:
        """The library for a type given by name; None for the bundled one.

        Search order: the user's folders, the bundled definitions, definitions sent by robots. If the user's
        has the md5sum of the bundled one, the bundled one is used, because programs import its class.

        Raises:
            DefinitionError: The user's own definition is damaged.
        """
        own = self._own
        if own is not None and own.defines(kind, name):
            same = bundled().has(kind, name) and bundled().md5sum(name, kind=kind) == own.md5sum(
                name, kind=kind
            )
            return None if same else own
        if bundled().has(kind, name):
            return None
        return next((library for library in self._learned_folders if library.defines(kind, name)), None)

    def message(self, ours: type[Message], md5sum: str, definition: str = "") -> type[Message] | None:
        """The class of the type of `ours` with this md5sum; None if unknown.

        Args:
            ours: The class in use.
            md5sum: The peer's md5sum.
            definition: Full text sent by the peer; ignored unless it has this md5sum.
        """
        binding: Binding | None = getattr(ours, "_binding", None)
        if not is_md5sum(md5sum) or binding is None:
            return None  # a class that genpy generated: only the text of its definition is known
        found = _remembered(self._found, ours, md5sum, lambda: self._find(binding, md5sum))
        return found or self._learned.get((ours, md5sum)) or self._defined(binding, md5sum, definition)

    def learn(self, ours: type[Message], md5sum: str, definition: str) -> type[Message] | None:
        """As `message`; a valid definition is kept for peers that do not send it themselves."""
        found = self.message(ours, md5sum, definition)
        if found is not None:
            self._learned.put((ours, md5sum), found, len(definition))
        return found

    def fetch(
        self, caller: CallerIdentity, topic: str, ours: type[Message], md5sum: str
    ) -> type[Message] | None:
        """Ask the topic's other publishers for the definition of the type of `ours` with that md5sum.

        For the unknown md5sum of a subscriber: a rospy subscriber sends its definition, a roscpp one does
        not. Every publisher sends its definition, and on a chassis the goal topics of the action servers have
        another publisher (`/ros_interface`). If its md5sum is the subscriber's, its definition is the missing
        one.

        Waits at most `FETCH_SECONDS`; a failed lookup is not repeated for `AGAIN_AFTER` seconds.

        Returns:
            The class; None if nobody has it.
        """
        if not self._may_ask(topic, md5sum):
            return None
        deadline = Deadline(FETCH_SECONDS)
        try:
            publishers = caller.master.get_system_state(timeout=deadline.remaining()).publishers.get(
                topic, []
            )
        except (RosError, OSError) as error:
            _log.debug("! %s: no node can be asked for a definition: %s", topic, error)
            return None
        for publisher in [name for name in publishers if name != caller.name][:MAX_ASKED]:
            try:
                reply = probe_topic(caller, topic, publisher, deadline)
            except (RosError, OSError) as error:
                _log.debug("! %s: %s does not provide its definition: %s", topic, publisher, error)
                continue
            if reply.md5sum == md5sum and reply.type_name == ours._type:
                found = self.learn(ours, md5sum, reply.message_definition)
                if found is not None:
                    _log.info("= %s: the definition %s was learned from %s", topic, md5sum, publisher)
                    return found
        return None

    def _may_ask(self, topic: str, md5sum: str) -> bool:
        now = time.monotonic()
        with self._lock:
            if now - self._asked.get((topic, md5sum), -AGAIN_AFTER) < AGAIN_AFTER:
                return False
            if len(self._asked) >= MAX_REMEMBERED:
                recent = {key: when for key, when in self._asked.items() if now - when < AGAIN_AFTER}
                if len(recent) >= MAX_REMEMBERED:
                    return False
                self._asked = recent
            self._asked[topic, md5sum] = now
            return True

    def service(self, ours: type[ServiceType], md5sum: str) -> type[ServiceType] | None:
        """The class of that service with this md5sum; None if unknown. Service headers carry no text."""
        if not is_md5sum(md5sum):
            return None
        return _remembered(self._found_services, ours, md5sum, lambda: self._find_service(ours, md5sum))

    def _find(self, ours: Binding, md5sum: str) -> type[Message] | None:
        for library in self._libraries(ours.spec.name, md5sum, "msg", ours.library):
            return message_class(ours.spec.name, library, value_style=ours.value_style)
        return None

    @staticmethod
    def _defined(ours: Binding, md5sum: str, definition: str) -> type[Message] | None:
        if not definition:
            return None
        try:
            learned = define(ours.spec.name, definition, value_style=ours.value_style)
        except (DefinitionError, CodecError, ValueError) as error:
            _log.debug("! %s: the definition a peer sent cannot be used: %s", ours.spec.name, error)
            return None
        return learned if learned._md5sum == md5sum else None

    def _find_service(self, ours: type[ServiceType], md5sum: str) -> type[ServiceType] | None:
        binding: Binding | None = getattr(ours._request_class, "_binding", None)
        if binding is None:
            return None
        for library in self._libraries(ours._type, md5sum, "srv", binding.library):
            return service_class(ours._type, library, value_style=binding.value_style)
        return None

    def _libraries(
        self, name: str, md5sum: str, kind: str, own: DefinitionLibrary
    ) -> Iterable[DefinitionLibrary]:
        """Libraries in which the type has that md5sum."""
        for library in (own, bundled(), self._own, *self._folders):
            if library is None:
                continue
            try:  # a damaged file in one folder must not block the others
                if not library.has(kind, name):
                    continue
                if library.md5sum(name, kind=kind) == md5sum:
                    yield library
                yield from (r.library for r in library.revisions(name, kind=kind) if r.md5sum == md5sum)
            except DefinitionError as error:
                _log.debug("! %s: %s", name, error)


C = TypeVar("C")


def _remembered(
    cache: BoundedCache[tuple[type, str], tuple[C]], ours: type, md5sum: str, find: Callable[[], C]
) -> C:
    found = cache.get((ours, md5sum))
    if found is None:
        found = (find(),)
        cache.put((ours, md5sum), found)
    return found[0]


class OwnDefinitionsOnly(KnownDefinitions):
    """For a node that takes its own definitions only and refuses all others, as rospy and roscpp do.

    `node.definitions = OwnDefinitionsOnly()` before anything is published, subscribed or provided.
    """

    def message(self, ours: type[Message], md5sum: str, definition: str = "") -> type[Message] | None:
        """Always None."""
        return None

    def service(self, ours: type[ServiceType], md5sum: str) -> type[ServiceType] | None:
        """Always None."""
        return None

    def fetch(
        self, caller: CallerIdentity, topic: str, ours: type[Message], md5sum: str
    ) -> type[Message] | None:
        """Always None."""
        return None
