"""The network between the simulated robot and everybody else: a delay, silence, a link that is down.

Everything passes here, both ways: messages the robot's nodes publish, and the commands they receive. A link
that is down keeps what is sent meanwhile and delivers it afterwards, as TCP does when a cable was pulled for
some seconds; so velocities of before the gap arrive after it.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import rosproto

_KEPT = 10  # messages of one publisher that wait for the link: as many as a publisher's queue holds


class Network:
    """Delays and interruptions, the same for all nodes of one robot. Safe from any thread.

    Attributes:
        delay: Seconds that everything takes, each way.
    """

    def __init__(self) -> None:
        self.delay = 0.0
        self._silent_until = 0.0
        self._down_until = 0.0
        self._lock = threading.Lock()
        self._queue: deque[tuple[float, object, Callable[[], object]]] = deque()
        self._closing = threading.Event()

    def fall_silent(self, seconds: float) -> None:
        """The steady topics end for a while; everything else goes on."""
        self._silent_until = time.monotonic() + seconds

    def drop(self, seconds: float) -> None:
        """Nothing passes for a while, in either direction; what is sent meanwhile comes afterwards."""
        self._down_until = time.monotonic() + seconds

    @property
    def silent(self) -> bool:
        """True while the steady topics are not to be published."""
        return time.monotonic() < self._silent_until

    @property
    def _quick(self) -> bool:
        return not self.delay and not self._queue and time.monotonic() >= self._down_until

    def carry(self, act: Callable[[], object], sender: object = None) -> None:
        """Do something when it arrives: now, or in `deliver`. The order is kept.

        Args:
            act: What the message does at the other end.
            sender: Of one sender only the last few are kept while the link is down; None keeps all.
        """
        if self._quick:
            act()
            return
        with self._lock:
            self._queue.append((self.arrival(), sender, act))
            if sender is not None:
                self._bound(sender)

    def _bound(self, sender: object) -> None:
        mine = [item for item in self._queue if item[1] is sender and item[0] >= self._down_until > 0.0]
        if len(mine) > _KEPT and time.monotonic() < self._down_until:
            self._queue.remove(mine[0])

    def deliver(self) -> None:
        """Do what has arrived by now; called again and again by the simulation's thread."""
        while True:
            with self._lock:
                if not self._queue or self._queue[0][0] > time.monotonic():
                    return
                act = self._queue.popleft()[2]
            act()

    def arrival(self) -> float:
        """When something sent now arrives, by our monotonic clock."""
        return max(time.monotonic() + self.delay, self._down_until)

    def travel(self) -> None:
        """Wait for as long as a request or a reply travels."""
        rest = self.arrival() - time.monotonic()
        if rest > 0.0:
            self._closing.wait(rest)

    def close(self) -> None:
        """Let nobody wait any longer."""
        self._closing.set()


class RobotNode(rosproto.Node):
    """A node of the robot: what it publishes passes the robot's network, also what an action server says."""

    def __init__(self, name: str, network: Network, **options: Any) -> None:
        self.network = network
        super().__init__(name, **options)

    def publisher(self, *arguments: Any, **options: Any) -> rosproto.Publisher:
        """As `Node.publisher`."""
        publisher = super().publisher(*arguments, **options)
        directly = publisher.publish

        def publish(message: Any = None, **fields: Any) -> None:
            if self.network._quick:
                directly(message, **fields)
            else:
                self.network.carry(lambda: _late(publisher, directly, message, fields), publisher)

        publisher.publish = publish  # type: ignore[method-assign]
        return publisher


def _late(
    publisher: rosproto.Publisher, directly: Callable[..., None], message: Any, fields: dict[str, Any]
) -> None:
    if not publisher.closed:
        directly(message, **fields)
