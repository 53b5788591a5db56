"""Player: a bag to a live graph, at the pace it was recorded."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from time import perf_counter
from typing import TYPE_CHECKING, Any

from rosproto.bag import BagReader, Connection, RawMessage
from rosproto.codec import message_class
from rosproto.time import Time

if TYPE_CHECKING:
    from types import TracebackType

    from rosproto.node import Node

__all__ = ["Player"]

_CLOCK = "/clock"
_QUEUE = 1000


class Player:
    """Plays a bag through a node. Use it in a `with` block: publishers exist from the beginning to the end
    of it.

    Topics that were latched are latched again. `pause`, `resume`, `step` and `stop` may be called from any
    thread while `play` runs.

    Args:
        node: The node to publish with.
        bag: What to play; it stays open.
        topics: Only these.
        rate: 2.0 plays twice as fast.
        start: Skip so many seconds of the bag.
        duration: Play so many seconds of the bag; None to its end.
        remap: Publish under another topic.
        clock_hz: Publish /clock with the bag's time so often a second (of this computer's time); None not.

    Raises:
        ValueError: The rate is not positive.
        BagError: A connection has no usable definition, or no such topic.
    """

    def __init__(
        self,
        node: Node,
        bag: BagReader,
        *,
        topics: Iterable[str] | None = None,
        rate: float = 1.0,
        start: float = 0.0,
        duration: float | None = None,
        remap: Mapping[str, str] | None = None,
        clock_hz: float | None = None,
    ) -> None:
        if not rate > 0:
            raise ValueError(f"rate {rate}: it must be more than 0")
        self._node, self._bag, self._rate = node, bag, rate
        self._topics = None if topics is None else list(topics)
        first = bag.start_time
        self._from = None if first is None else first.to_sec() + start
        self._to = None if self._from is None or duration is None else self._from + duration
        self._clock_hz = clock_hz
        self._changed = threading.Condition()
        self._paused = self._stopped = False
        self._steps = 0
        names = remap or {}
        self._publishers = {
            connection.id: node.publisher(
                names.get(connection.topic, connection.topic),
                bag.message_class(connection),
                latch=connection.latching,
                queue_size=_QUEUE,
            )
            for connection in self._connections()
        }
        self._clock_out = (
            node.publisher(_CLOCK, "rosgraph_msgs/Clock", queue_size=1) if clock_hz is not None else None
        )

    def __enter__(self) -> Player:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def wait_for_subscribers(self, timeout: float | None = 10.0) -> None:
        """Wait until every topic has a subscriber.

        Raises:
            RosTimeout: One has none.
        """
        for publisher in self._publishers.values():
            publisher.wait_for_connection(timeout)

    def play(self, on_message: Callable[[str, Time], object] | None = None) -> int:
        """Publish everything once, each message at its time; returns how many.

        Args:
            on_message: Called with topic and recorded time after each message.
        """
        count = 0
        self._stopped = False
        origin: float | None = None
        began = 0.0
        for topic, raw, stamp in self._messages():
            at = stamp.to_sec()
            if origin is None:
                origin, began = at, perf_counter()
            stepped, paused = self._wait_until(began + (at - origin) / self._rate, at)
            began += paused
            if self._stopped:
                break
            if stepped:  # the pace goes on from here
                began = perf_counter() - (at - origin) / self._rate
            self._publishers[raw.connection.id].publish(raw.data)
            count += 1
            if on_message is not None:
                on_message(topic, stamp)
        return count

    def pause(self) -> None:
        """Hold before the next message."""
        with self._changed:
            self._paused = True
            self._changed.notify_all()

    def resume(self) -> None:
        """Go on."""
        with self._changed:
            self._paused = False
            self._changed.notify_all()

    def step(self) -> None:
        """While paused: publish one message."""
        with self._changed:
            self._steps += 1
            self._changed.notify_all()

    def stop(self) -> None:
        """End `play` before its next message."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def close(self) -> None:
        """Stop, and stop publishing."""
        self.stop()
        for publisher in (*self._publishers.values(), self._clock_out):
            if publisher is not None:
                publisher.close()

    def _connections(self) -> list[Connection]:
        names = self._bag.topics if self._topics is None else self._topics
        return [connection for name in names for connection in self._bag._topic(name).connections]

    def _messages(self) -> Iterator[tuple[str, RawMessage, Time]]:
        return self._bag.read_messages(self._topics, self._from, self._to, raw=True)

    def _wait_until(self, due: float, bag_time: float) -> tuple[bool, float]:
        """Wait for the moment, /clock ticking; whether it was a step, and the seconds of pause."""
        paused_since: float | None = None
        paused = 0.0
        with self._changed:
            while not self._stopped:
                now = perf_counter()
                if self._paused:
                    if self._steps:
                        self._steps -= 1
                        return True, 0.0
                    paused_since = now if paused_since is None else paused_since
                    self._changed.wait(1.0)
                    continue
                if paused_since is not None:
                    paused += now - paused_since
                    paused_since = None
                left = due + paused - now
                if left <= 0:
                    self._tick(bag_time)
                    return False, paused
                tick = left if self._clock_hz is None else min(left, 1.0 / self._clock_hz)
                self._tick(bag_time - left * self._rate)
                self._changed.wait(tick)
        return False, paused

    def _tick(self, bag_time: float) -> None:
        if self._clock_out is None:
            return
        message: Any = message_class("rosgraph_msgs/Clock")()
        message.clock = Time.from_sec(max(bag_time, 0.0))
        self._clock_out.publish(message)
