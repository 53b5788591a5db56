"""The feeds of one chassis, one for each topic, and the waits on them. Safe from any thread."""

from __future__ import annotations

import threading
import time
from contextlib import closing
from typing import Any

from rosproto import Node
from rosproto.errors import RosError, RosTimeout
from rosproto.node import fresh_messages
from rosproto.sentence import both, say
from rosproto.transport import Deadline
from woosh_pure.connection.connection import Connection
from woosh_pure.errors import StaleState
from woosh_pure.feed.feed import Feed
from woosh_pure.geometry import Velocity
from woosh_pure.interface import find, row
from woosh_pure.values.convert import to_value
from woosh_pure.values.messages import message_type

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

    def require_publisher(self, feed: Feed[object]) -> None:
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

    def wait_standing(self, timeout: float, *, steady: float = 0.0) -> bool | None:
        """Whether the robot stands still, by what it publishes after this call.

        A measurement that arrives now may have been made before a stop was sent: a network can delay it for
        seconds, and it has no stamp. So the robot is read through a connection that is made now
        (`rosproto.node.fresh_messages`). True needs two measurements in succession.

        Args:
            timeout: Seconds for all of it; in a slow network, connecting takes several times its delay.
            steady: For how many seconds it must be measured standing.

        Returns:
            True if it stands, False if it moves when the time is up, None if that is not known.
        """
        deadline = Deadline(timeout)
        try:
            feed: Feed[Velocity] = self.get("velocity").open()
            node = self._connection.open_node()
            while not (addresses := feed.sources):
                if deadline.expired or feed.closed or feed.in_callback:
                    return None
                time.sleep(_LOOK)
            answers = [_stands(node, feed, address, deadline, steady) for address in sorted(addresses)]
        except (RosError, OSError, ValueError):
            return None
        return False if False in answers else None if None in answers else True


def _stands(node: Node, feed: Feed[Velocity], address: str, deadline: Deadline, steady: float) -> bool | None:
    """`Feeds.wait_standing` by one publisher."""
    kind = feed.row.type
    standing, since = None, 0.0
    with closing(fresh_messages(node, feed.topic, message_type(kind), address, deadline)) as messages:
        for message in messages:
            before, standing = standing, to_value(kind, message).is_standing()
            if standing and not before:
                since = time.monotonic()
            elif standing and time.monotonic() - since >= steady:
                return True
    return None if standing else standing  # a single measurement, or not for long enough
