"""`MessageEvent`: a received message, decoded and encoded once for all clients, and `TopicDescription`."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, TypeVar

from rosproto.codec import Message
from rosproto.errors import RosError
from rosproto.node.definitions.topic_type import TopicType
from rosproto.node.definitions.type_argument import learn_type
from rosproto.time import Time

T = TypeVar("T")


@dataclass(slots=True, eq=False, repr=False)
class TopicDescription:
    """A topic as described by a publisher in its connection header.

    Attributes:
        topic: Resolved name.
        type_name: "package/Type".
        md5sum: Of its definition.
        definition: Full text, with those of all types used; "" if neither the publisher nor we have it.
        latched: Whether the publisher latches.
        publisher: Its caller id.
    """

    topic: str
    type_name: str
    md5sum: str
    definition: str
    _: KW_ONLY
    latched: bool
    publisher: str
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False)
    _type: TopicType | RosError | None = field(default=None, init=False)

    @property
    def type(self) -> TopicType:
        """The type by its definition.

        Raises:
            RosError: The definition cannot be used.
        """
        with self._lock:
            if self._type is None:
                try:
                    self._type = learn_type(
                        self.type_name,
                        self.md5sum,
                        self.definition,
                        topic=self.topic,
                        peer=self.publisher or "a publisher",
                    )
                except RosError as error:
                    self._type = error
            if isinstance(self._type, RosError):
                raise self._type
            return self._type

    def __repr__(self) -> str:
        return f"<TopicDescription {self.topic} {self.type_name} of {self.publisher}>"


@dataclass(slots=True, eq=False, repr=False)
class MessageEvent:
    """A message of a topic, for any number of receivers.

    Attributes:
        description: The topic, as its publisher describes it.
        data: The encoded message, as it was received.
        received: When, by the monotonic clock.
        stamp: When, by the node's ROS clock (the simulation's, where there is one).
    """

    description: TopicDescription
    data: bytes | memoryview
    received: float
    stamp: Time
    _lock: threading.RLock = field(default_factory=threading.RLock, init=False)
    _made: dict[object, Any] = field(default_factory=dict, init=False)

    @property
    def topic(self) -> str:
        """Resolved name of its topic."""
        return self.description.topic

    @property
    def type_name(self) -> str:
        """ "package/Type"."""
        return self.description.type_name

    @property
    def md5sum(self) -> str:
        """Of its publisher's definition."""
        return self.description.md5sum

    @property
    def definition(self) -> str:
        """Full text of its publisher's definition."""
        return self.description.definition

    @property
    def latched(self) -> bool:
        """Whether its publisher latches."""
        return self.description.latched

    @property
    def message_class(self) -> type[Message]:
        """Class of `message`.

        Raises:
            RosError: The publisher's definition cannot be used.
        """
        return self.description.type.message_class

    @property
    def message(self) -> Any:
        """The message, decoded with the first use; shared, so do not change it.

        Raises:
            RosError: The publisher's definition cannot be used, or its bytes do not fit it.
        """
        return self.once("message", self._decode)

    def _decode(self) -> Message:
        return self.description.type.decode(self.data, 0, len(self.data))

    def once(self, key: object, make: Callable[..., T], *args: object) -> T:
        """Return `make(*args)`, computed at the first use of `key` and kept for all clients.

        Another thread with the same key waits for the result. An exception is not kept.
        """
        made: T
        try:
            made = self._made[key]
        except KeyError:
            with self._lock:
                if key in self._made:
                    made = self._made[key]
                else:
                    made = self._made[key] = make(*args)
        return made

    def has(self, key: object) -> bool:
        """Whether `once(key, ...)` has a result already."""
        return key in self._made

    def __repr__(self) -> str:
        return f"<MessageEvent of {self.topic} {self.type_name}, {len(self.data)} bytes>"
