"""Play no faster than a node can follow: the bags' time waits for a topic that shows how far the node is.

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
    """Follows a topic. The header stamps of its messages are bag time; without a stamp, arrival counts.

    Args:
        node: The node that subscribes.
        topic: A topic of the node that has to keep up.
        most_delay: Seconds of bag time that playing may be ahead of the newest message.
        position: The bag time reached, ns.

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
        """Forget earlier messages: the bags' time was set anew, and they say nothing about it."""
        self._reached_ns = self._position()

    def close(self) -> None:
        """Stop following."""
        self._subscriber.close()

    def _take(self, message: Any) -> None:
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        self._reached_ns = self._position() if stamp is None else stamp.secs * NS + stamp.nsecs
