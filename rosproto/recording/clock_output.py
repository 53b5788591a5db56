"""The clock of a player: publishes the bags' time on /clock, at a fixed rate of real time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.codec import message_class
from rosproto.time import Time

if TYPE_CHECKING:
    from rosproto.node import Node

__all__ = ["ClockOutput"]

NS = 1_000_000_000


class ClockOutput:
    """Publishes /clock.

    Attributes:
        due: When the next message is due.
    """

    def __init__(self, node: Node, hz: float) -> None:
        self._publisher = node.publisher("/clock", message_class("rosgraph_msgs/Clock"), queue_size=100)
        self._period = 1.0 / hz
        self.due = 0.0

    def publish(self, time_ns: int) -> None:
        """Publish this time (ns)."""
        self._publisher.publish(clock=Time.from_wire(*divmod(time_ns, NS)))

    def advance(self, now: float) -> None:
        """Schedule the next message; missed ones are left out."""
        self.due = max(self.due + self._period, now)

    def close(self) -> None:
        """Stop publishing."""
        self._publisher.close()
