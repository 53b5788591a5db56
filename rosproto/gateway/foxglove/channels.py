"""The channels that one client is offered, and those it follows.

A channel is a topic with its schema. It costs the robot nothing until the client subscribes it.
"""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

from rosproto.errors import RosError
from rosproto.gateway.foxglove.graph import GraphView
from rosproto.gateway.foxglove.schemas import TopicSchema
from rosproto.gateway.foxglove.sdk import sdk
from rosproto.gateway.taps import Receiver

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.shared import Shared

__all__ = ["Channels", "OfferedChannel"]

ENCODING, SCHEMA_ENCODING = "ros1", "ros1msg"
SDK_TABLE = "_channels_by_id"


class Closes(Protocol):
    def close(self) -> None: ...


class OfferedChannel:
    """One channel of one client.

    Attributes:
        topic: Its name.
        schema: As the client was told.
        channel: The SDK's.
        id: Its number in the SDK.
        closed: It is no longer offered.
    """

    __slots__ = ("channel", "closed", "id", "schema", "topic")

    def __init__(self, context: Any, topic: str, schema: TopicSchema) -> None:
        fg = sdk()
        self.topic, self.schema = topic, schema
        self.channel: Any = fg.Channel(
            topic,
            schema=fg.Schema(
                name=schema.type_name, encoding=SCHEMA_ENCODING, data=schema.definition.encode()
            ),
            message_encoding=ENCODING,
            context=context,
        )
        self.id: int = self.channel.id()
        self.closed = False

    def close(self) -> None:
        """Stop offering it."""
        self.closed = True
        self.channel.close()
        # The SDK's Python code keeps every channel ever made, and a gateway makes new ones for each client.
        kept = vars(importlib.import_module("foxglove.channel")).get(SDK_TABLE)
        if isinstance(kept, dict):
            kept.pop(self.id, None)


class Channels:
    """All channels of one client.

    Args:
        context: The SDK's, one for each client.
        shared: Knows schemas, and follows topics.
    """

    def __init__(self, context: Any, shared: Shared) -> None:
        self._context = context
        self._shared = shared
        self._lock = threading.RLock()
        self._turn = threading.Lock()
        self._offered: dict[str, OfferedChannel] = {}
        self._by_id: dict[int, OfferedChannel] = {}
        self._taps: dict[int, tuple[int, Closes]] = {}
        self._closed = False

    @property
    def followed(self) -> tuple[str, ...]:
        """The topics that the client follows."""
        with self._lock:
            return tuple(sorted(self._by_id[id].topic for id in self._taps if id in self._by_id))

    def show(self, view: GraphView) -> None:
        """Offer exactly the topics of a view."""
        wanted = self._shared.offered(view)
        with self._lock:
            if self._closed:
                return
            for topic in [topic for topic, one in self._offered.items() if wanted.get(topic) != one.schema]:
                self._withdraw(topic)
            for topic, schema in wanted.items():
                if topic not in self._offered:
                    self._offer(topic, schema)

    def renew(self, topic: str) -> None:
        """Offer a topic again if its schema has changed."""
        schema = self._shared.offered(self._shared.view).get(topic)
        with self._lock:
            present = self._offered.get(topic)
            if self._closed or present is None or schema is None or present.schema == schema:
                return
            self._withdraw(topic)
            self._offer(topic, schema)

    def clear(self) -> None:
        """Stop offering everything."""
        with self._lock:
            for topic in tuple(self._offered):
                self._withdraw(topic)

    def _offer(self, topic: str, schema: TopicSchema) -> None:
        one = self._offered[topic] = OfferedChannel(self._context, topic, schema)
        self._by_id[one.id] = one

    def _withdraw(self, topic: str) -> None:
        one = self._offered.pop(topic)
        self._by_id.pop(one.id, None)
        one.close()

    def follow(
        self, wanted: Mapping[int, int], receiver: Callable[[OfferedChannel], Receiver]
    ) -> list[tuple[str, str]]:
        """Follow exactly these channels at the robot; asks the master. Returns what failed, and why.

        Args:
            wanted: Channel -> number of its subscription. A new number means a new subscription, which
                gets the latched messages even if the channel was followed before: a viewer whose panels
                change unsubscribes a topic and subscribes it again at once.
            receiver: Makes the receiver of a channel's messages.
        """
        problems: list[tuple[str, str]] = []
        with self._turn:
            with self._lock:
                present = {id: wanted[id] for id in wanted if id in self._by_id and not self._closed}
                ending = [
                    id for id, (subscription, _) in self._taps.items() if present.get(id) != subscription
                ]
                leaving = [self._taps.pop(id)[1] for id in ending]
                new = [self._by_id[id] for id in sorted(set(present) - set(self._taps))]
            for tap in leaving:
                tap.close()
            for channel in new:
                if len(self._taps) >= self._shared.limits.subscriptions_per_client:
                    problems.append((channel.topic, f"{len(self._taps)} topics are followed, no more can be"))
                    break
                try:
                    tap = self._shared.tap(channel.topic, receiver(channel))
                except (RosError, ValueError) as problem:
                    problems.append((channel.topic, str(problem)))
                    continue
                with self._lock:
                    self._taps[channel.id] = present[channel.id], tap
        return problems

    def close(self) -> None:
        """Stop offering and following everything."""
        with self._lock:
            self._closed = True
            self.clear()
        with self._turn:
            with self._lock:
                ending = [tap for _, tap in self._taps.values()]
                self._taps.clear()
            for tap in ending:
                tap.close()
