"""The timing of a replay: exact waiting, a topic that limits the speed, and /clock.

`Pacer` waits for a moment with an error of tens of microseconds, without keeping a processor busy. Operating
systems wake a sleeping thread late: by 60 us on Linux, by up to 15 ms on an old Windows. So the pacer sleeps
until shortly before the moment and spins for the rest. How long it spins depends on how late it was woken
before.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from rosproto.codec import message_class
from rosproto.node import Node
from rosproto.time import Time

MIN_SPIN = 0.0001
MAX_SPIN = 0.003  # seconds; spinning cannot make up for wake-ups later than this


class Pacer:
    """Waits for moments of a monotonic clock.

    Args:
        now: The clock, seconds.
        sleep: Sleeps for that many seconds, perhaps longer.

    Attributes:
        spin: How many seconds before the moment sleeping ends.
    """

    def __init__(
        self, now: Callable[[], float] = time.perf_counter, sleep: Callable[[float], object] = time.sleep
    ) -> None:
        self.now = now
        self._sleep = sleep
        self.spin = 0.0003

    def wait_until(self, moment: float) -> None:
        """Return at that moment, or immediately if it has passed."""
        left = moment - self.now()
        if left > self.spin:
            self._rest(left - self.spin)
        while self.now() < moment:
            self._sleep(0)  # yields the interpreter to the sending threads

    def _rest(self, seconds: float) -> None:
        before = self.now()
        self._sleep(seconds)
        late = self.now() - before - seconds
        # Increase fast, decrease slowly: a late wake-up misses the moment, while spinning costs little.
        wanted = min(max(1.5 * late, MIN_SPIN), MAX_SPIN)
        self.spin = wanted if wanted > self.spin else self.spin + 0.02 * (wanted - self.spin)


# -- the rate control topic ---------------------------------------------------------------------------------
# Play no faster than a node can follow: the bags' time waits for a topic that shows how far the node is.
#
# Source: rosbag player.cpp, updateRateTopicTime.


NS = 1_000_000_000


class RateControl:
    """Follows a topic. The header stamps of its messages are bag time; without a stamp, arrival counts.

    Args:
        node: The node that subscribes.
        topic: A topic of the node that has to keep up.
        max_delay: Seconds of bag time that playing may be ahead of the newest message.
        position: The bag time reached, ns.

    Attributes:
        topic: Its name.
    """

    def __init__(self, node: Node, topic: str, max_delay: float, position: Callable[[], int]) -> None:
        if not max_delay >= 0:
            raise ValueError(f"rate_control_delay {max_delay}: seconds, 0 or more")
        self.topic = topic
        self._max_ns = round(max_delay * NS)
        self._position = position
        self._reached_ns = position()
        self._subscriber = node.subscriber(topic, None, self._take, queue_size=10)

    @property
    def behind(self) -> bool:
        """Whether playing has to wait for the next message."""
        return self._position() - self._reached_ns > self._max_ns

    def restart(self) -> None:
        """Forget earlier messages: the bags' time was set anew."""
        self._reached_ns = self._position()

    def close(self) -> None:
        """Stop following."""
        self._subscriber.close()

    def _take(self, message: object) -> None:
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        self._reached_ns = self._position() if stamp is None else stamp.to_nsec()


# -- /clock -------------------------------------------------------------------------------------------------


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
