"""The channels one client is offered, and which of them it follows.

A channel is a topic with its definition. It costs the robot nothing until the client subscribes it.
"""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

from rosproto.errors import RosError
from rosproto.gateway.foxglove.graph import GraphView
from rosproto.gateway.foxglove.schemas import Described
from rosproto.gateway.foxglove.sdk import sdk
from rosproto.gateway.taps import Receiver

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.shared import House

__all__ = ["Channels", "Shown"]

ENCODING, SCHEMA_ENCODING = "ros1", "ros1msg"
SDK_TABLE = "_channels_by_id"


class Closes(Protocol):
    def close(self) -> None: ...


class Shown:
    """One channel of one client.

    Attributes:
        topic: Its name.
        described: Type and definition, as the client was told.
        channel: The SDK's.
        id: Its number there.
        closed: It is not offered any more.
    """

    __slots__ = ("channel", "closed", "described", "id", "topic")

    def __init__(self, context: Any, topic: str, described: Described) -> None:
        fg = sdk()
        self.topic, self.described = topic, described
        self.channel: Any = fg.Channel(
            topic,
            schema=fg.Schema(
                name=described.type_name, encoding=SCHEMA_ENCODING, data=described.definition.encode()
            ),
            message_encoding=ENCODING,
            context=context,
        )
        self.id: int = self.channel.id()
        self.closed = False

    def close(self) -> None:
        """Take it back."""
        self.closed = True
        self.channel.close()
        # The SDK's Python side keeps every channel that was ever made; a gateway makes them for each client.
        kept = vars(importlib.import_module("foxglove.channel")).get(SDK_TABLE)
        if isinstance(kept, dict):
            kept.pop(self.id, None)


class Channels:
    """All channels of one client.

    Args:
        context: The SDK's, of this client alone.
        house: Where topics are described and followed.
    """

    def __init__(self, context: Any, house: House) -> None:
        self._context = context
        self._house = house
        self._lock = threading.RLock()
        self._turn = threading.Lock()
        self._shown: dict[str, Shown] = {}
        self._by_id: dict[int, Shown] = {}
        self._taps: dict[int, tuple[int, Closes]] = {}
        self._closed = False

    @property
    def followed(self) -> tuple[str, ...]:
        """Topics that the client follows."""
        with self._lock:
            return tuple(sorted(self._by_id[id].topic for id in self._taps if id in self._by_id))

    def show(self, view: GraphView) -> None:
        """Offer what is in a view, and nothing else."""
        wanted = self._house.offered(view)
        with self._lock:
            if self._closed:
                return
            for topic in [topic for topic, one in self._shown.items() if wanted.get(topic) != one.described]:
                self._take_back(topic)
            for topic, described in wanted.items():
                if topic not in self._shown:
                    self._offer(topic, described)

    def renew(self, topic: str) -> None:
        """Offer one topic with what is known of it now."""
        described = self._house.offered(self._house.view).get(topic)
        with self._lock:
            present = self._shown.get(topic)
            if self._closed or present is None or described is None or present.described == described:
                return
            self._take_back(topic)
            self._offer(topic, described)

    def clear(self) -> None:
        """Take everything back."""
        with self._lock:
            for topic in tuple(self._shown):
                self._take_back(topic)

    def _offer(self, topic: str, described: Described) -> None:
        one = self._shown[topic] = Shown(self._context, topic, described)
        self._by_id[one.id] = one

    def _take_back(self, topic: str) -> None:
        one = self._shown.pop(topic)
        self._by_id.pop(one.id, None)
        one.close()

    def follow(
        self, wanted: Mapping[int, int], follower: Callable[[Shown], Receiver]
    ) -> list[tuple[str, str]]:
        """Follow these channels at the robot, and no others; asks the master. What could not be, and why.

        Args:
            wanted: Channel -> which subscription of it: a new one gets what is latched, although it was
                followed before. (A viewer whose panels change leaves a topic and takes it again at once.)
            follower: Takes the messages of a channel.
        """
        problems: list[tuple[str, str]] = []
        with self._turn:
            with self._lock:
                present = {id: wanted[id] for id in wanted if id in self._by_id and not self._closed}
                over = [id for id, (subscription, _) in self._taps.items() if present.get(id) != subscription]
                leaving = [self._taps.pop(id)[1] for id in over]
                new = [self._by_id[id] for id in sorted(set(present) - set(self._taps))]
            for tap in leaving:
                tap.close()
            for channel in new:
                if len(self._taps) >= self._house.limits.subscriptions_per_client:
                    problems.append((channel.topic, f"{len(self._taps)} topics are followed, no more can be"))
                    break
                try:
                    tap = self._house.tap(channel.topic, follower(channel))
                except (RosError, ValueError) as problem:
                    problems.append((channel.topic, str(problem)))
                    continue
                with self._lock:
                    self._taps[channel.id] = present[channel.id], tap
        return problems

    def close(self) -> None:
        """Take everything back, leave everything."""
        with self._lock:
            self._closed = True
            self.clear()
        with self._turn:
            with self._lock:
                over = [tap for _, tap in self._taps.values()]
                self._taps.clear()
            for tap in over:
                tap.close()
