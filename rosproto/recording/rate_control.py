"""Playing no faster than somebody follows: the bags' time waits for a topic that tells how far a node is.

Source: rosbag player.cpp, updateRateTopicTime.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rosproto.node import Node

__all__ = ["RateControl"]

NS = 1_000_000_000


class RateControl:
    """Follows a topic. Header stamps of its messages are bag time; without one it counts when it came.

    Args:
        node: Subscribes.
        topic: Published by who is to keep up.
        most_delay: Seconds of bag time that playing may be ahead of the newest message.
        position: Bag time reached, ns.

    Attributes:
        topic: Its name.
    """

    def __init__(self, node: Node, topic: str, most_delay: float, position: Callable[[], int]) -> None:
        if not most_delay >= 0:
            raise ValueError(f"rate_control_delay {most_delay}: seconds, 0 or more")
        self.topic = topic
        self._most_ns = round(most_delay * NS)
        self._position = position
        self._reached_ns = position()
        self._subscriber = node.subscriber(topic, None, self._take, queue_size=10)

    @property
    def behind(self) -> bool:
        """Whether playing has to wait for the next message."""
        return self._position() - self._reached_ns > self._most_ns

    def restart(self) -> None:
        """The bags' time was set anew: what came before says nothing about it."""
        self._reached_ns = self._position()

    def close(self) -> None:
        """Stop following."""
        self._subscriber.close()

    def _take(self, message: Any) -> None:
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        self._reached_ns = self._position() if stamp is None else stamp.secs * NS + stamp.nsecs
