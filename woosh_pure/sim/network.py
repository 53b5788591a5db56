"""The simulated network of the robot: delay, silence and interruptions.

The messages that the robot's nodes publish and the commands they receive pass through it. During an
interruption messages are kept and delivered afterwards, as TCP does when a cable was pulled for some seconds;
so old velocities arrive after it.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import rosproto

_KEPT = 10  # messages of one publisher that are kept during an interruption, as in a publisher's queue


class Network:
    """Delays and interruptions, the same for all nodes of one robot. Safe from any thread.

    Attributes:
        delay: Delay of each message in seconds, each way.
    """

    def __init__(self) -> None:
        self.delay = 0.0
        self._silent_until = 0.0
        self._down_until = 0.0
        self._lock = threading.Condition()
        self._queue: deque[tuple[float, object, Callable[[], object]]] = deque()
        self._closing = False

    def fall_silent(self, seconds: float) -> None:
        """Stop the periodic topics for a while; everything else goes on."""
        self._silent_until = time.monotonic() + seconds

    def drop(self, seconds: float) -> None:
        """Interrupt both directions for a while; messages are delivered afterwards."""
        self._down_until = time.monotonic() + seconds

    def restore(self) -> None:
        """End delay, silence and interruption; what is on its way is delivered at once."""
        with self._lock:
            self.delay = self._silent_until = self._down_until = 0.0
            self._queue = deque((0.0, sender, act) for _, sender, act in self._queue)
            self._lock.notify_all()

    @property
    def silent(self) -> bool:
        """Whether the periodic topics are stopped."""
        return time.monotonic() < self._silent_until

    @property
    def _is_immediate(self) -> bool:
        return not self.delay and not self._queue and time.monotonic() >= self._down_until

    def carry(self, act: Callable[[], object], sender: object = None) -> None:
        """Deliver a message: now, or later in `deliver`, in the order of sending.

        Args:
            act: Called on delivery.
            sender: Only the last few messages of a sender are kept during an interruption; None keeps all.
        """
        if self._is_immediate:
            act()
            return
        with self._lock:
            self._queue.append((self.arrival(), sender, act))
            if sender is not None:
                self._drop_excess(sender)

    def _drop_excess(self, sender: object) -> None:
        mine = [item for item in self._queue if item[1] is sender and item[0] >= self._down_until > 0.0]
        if len(mine) > _KEPT and time.monotonic() < self._down_until:
            self._queue.remove(mine[0])

    def deliver(self) -> None:
        """Deliver the messages that are due; called periodically by the simulation's thread."""
        while True:
            with self._lock:
                if not self._queue or self._queue[0][0] > time.monotonic():
                    return
                act = self._queue.popleft()[2]
            act()

    def arrival(self) -> float:
        """The monotonic time at which a message sent now arrives."""
        return max(time.monotonic() + self.delay, self._down_until)

    def travel(self) -> None:
        """Wait for the delay of a request or reply."""
        arrives = self.arrival()
        with self._lock:
            while not self._closing and (rest := self.earlier(arrives) - time.monotonic()) > 0.0:
                self._lock.wait(rest)

    def earlier(self, arrives: float) -> float:
        """When what is on its way arrives: at its time, or at once after `restore`."""
        return min(arrives, self.arrival())

    def close(self) -> None:
        """End all waits."""
        with self._lock:
            self._closing = True
            self._lock.notify_all()


class RobotNode(rosproto.Node):
    """A node of the robot, whose messages pass the simulated network, those of action servers included."""

    def __init__(self, name: str, network: Network, **options: Any) -> None:
        self.network = network
        super().__init__(name, **options)

    def publisher(self, *arguments: Any, **options: Any) -> rosproto.Publisher:
        """As `Node.publisher`."""
        publisher = super().publisher(*arguments, **options)
        directly = publisher.publish

        def publish(message: Any = None, **fields: Any) -> None:
            def deliver() -> None:
                if not publisher.closed:
                    directly(message, **fields)

            if self.network._is_immediate:
                directly(message, **fields)
            else:
                self.network.carry(deliver, publisher)

        publisher.publish = publish  # type: ignore[method-assign]
        return publisher
