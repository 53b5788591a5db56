"""The feeds of one chassis, one for each topic, and the waits on them. Safe from any thread."""

from __future__ import annotations

import threading
import time
from typing import Any

from rosproto.errors import RosError, RosTimeout
from rosproto.sentence import both, say
from rosproto.transport import Deadline
from woosh_pure.connection.connection import Connection
from woosh_pure.errors import StaleState
from woosh_pure.feed.feed import Feed
from woosh_pure.geometry import Velocity
from woosh_pure.interface import find, row

# A link counts as lost when its publisher has been away for this long. A restart of one of the chassis's
# nodes takes about a second and is no reason to give up a task.
_LOST_AFTER = 5.0
_LOOK = 0.02  # seconds


class Feeds:
    """The feeds of one chassis: each is made on first use, all are closed by `close`.

    Args:
        connection: Its node subscribes.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._lock = threading.RLock()  # never held during network waits
        self._feeds: dict[str, Feed[Any]] = {}
        self._missing_since: dict[str, float] = {}

    def get(self, name: str) -> Feed[Any]:
        """The feed of that name, or of a topic that has no name; it subscribes on first reading."""
        if (made := self._feeds.get(name)) is not None:
            return made  # no lock: `stop` must not wait for a frame that it has interrupted
        with self._lock:
            if name not in self._feeds:
                found = row(name) if name.startswith("/") else find(name)
                self._feeds[name] = Feed(found, self._connection.open_node)
            return self._feeds[name]

    def used(self, name: str) -> Feed[Any] | None:
        """The feed of that name if it was used before; makes none."""
        return self._feeds.get(name)

    @property
    def opened(self) -> set[str]:
        """Names of the feeds used so far."""
        with self._lock:
            return set(self._feeds)

    def close(self) -> None:
        """End their subscriptions; may be called again."""
        with self._lock:
            feeds = list(self._feeds.values())
        for feed in feeds:
            feed.close()

    def require_publisher(self, feed: Feed[Any]) -> None:
        """Wait until the topic that reports the end of a goal is connected.

        Raises:
            StaleState: It has no publisher, so the end of the goal could not be seen.
        """
        seconds = self._connection.timeout
        deadline = Deadline(seconds)
        while feed.publishers == 0:
            if deadline.expired:
                unseen = "{topic}: no publisher within {seconds} s, so the end of a task could not be seen"
                why = (feed.unreachable,) if feed.unreachable else ()
                text = both(say(unseen, topic=feed.topic, seconds=seconds), *why, "check `woosh doctor`")
                raise StaleState(text, topic=feed.topic)
            time.sleep(0.01)

    def require_heard(self, name: str, timeout: float) -> None:
        """Wait for a feed's first value.

        Raises:
            StaleState: None came in time.
        """
        feed = self.get(name)
        try:
            feed.wait(timeout, new=False)
        except RosTimeout as error:
            raise StaleState(
                say(
                    "{topic} is silent, so nobody could see whether the robot obeys; check the chassis, or "
                    "pass feedback_timeout=None to drive without it",
                    topic=feed.topic,
                ),
                topic=feed.topic,
                age=feed.age,
            ) from error

    def lost(self, name: str) -> str:
        """Why the link of a feed counts as lost; "" while it is up."""
        feed = self.get(name)
        if feed.publishers > 0:
            self._missing_since.pop(name, None)
        else:
            since = self._missing_since.setdefault(name, time.monotonic())
            if time.monotonic() - since > _LOST_AFTER:
                return say(
                    "{topic} has had no publisher for {seconds} s", topic=feed.topic, seconds=_LOST_AFTER
                )
        beat = self.get("velocity")
        age = beat.age
        if age is not None and age > _LOST_AFTER:
            return say("the chassis has been silent for {seconds:.1f} s ({why})", seconds=age, why=beat.topic)
        return ""

    def wait_standing(self, timeout: float) -> bool | None:
        """Whether the robot stands still: True once that is measured, False if it moves, None if unknown."""
        began = time.monotonic()
        try:
            feed: Feed[Velocity] = self.get("velocity").open()
        except RosError:
            return None
        while True:  # polled: a wait could be blocked by another thread
            reading = feed.known
            fresh = reading is not None and reading.received >= began
            if fresh and reading is not None and reading.value.is_standing():
                return True
            over = time.monotonic() >= began + timeout
            if over or feed.closed or feed.in_callback:
                return False if over and fresh else None
            time.sleep(_LOOK)
