"""The velocity topics, as one client writes them: publishers that are there only while somebody drives.

A registered publisher tells other programs that somebody can drive the base (`other_drivers`), so it is
unregistered when its last user is done. After a lost link it stays until zero has been the first thing sent.
"""

from __future__ import annotations

import threading
from collections import Counter
from typing import TYPE_CHECKING

from rosproto.errors import RosError
from rosproto.logs import get_logger
from woosh_pure.geometry import Velocity
from woosh_pure.interface.table import row
from woosh_pure.values.messages import twist
from woosh_pure.values.rostypes import message_type

if TYPE_CHECKING:
    import rosproto
    from woosh_pure.connection.connection import Connection

__all__ = ["VELOCITY_TOPICS", "VelocityTopics"]

VELOCITY_TOPICS = {"smooth": "/smooth_cmd_vel", "direct": "/base_cmd_vel"}
logger = get_logger("woosh_pure.velocity")
_FLUSH = 0.5  # seconds
_ARRIVE = 0.5  # seconds
_ELSEWHERE = 2.0  # seconds for somebody to listen
_ZEROS = 5


class VelocityTopics:
    """Publishers of the velocity topics, counted by use. Safe from any thread."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._lock = threading.RLock()  # never held while the network is waited for
        self._making = threading.RLock()
        self._publishers: dict[str, rosproto.Publisher] = {}
        self._users: Counter[str] = Counter()
        self._zero_due: set[str] = set()

    def acquire(self, topic: str) -> rosproto.Publisher:
        """The publisher of a topic, until `release`: a queue of one, never latched, and nothing delivered
        after the program was killed, so that no old velocity can be sent.

        Raises:
            RosError: It cannot be registered.
        """
        made = self._take(topic)  # without waiting: `stop` must not wait for another verb that is connecting
        if made is not None:
            return made
        with self._making:
            made = self._take(topic)
            if made is not None:
                return made
            made = self._connection.open_node().publisher(
                topic,
                message_type(row(topic).type),
                queue_size=1,
                latch=False,
                linger=False,  # nothing of a killed program may arrive later
                on_connect=lambda _: self._reconnected(topic),
            )
            with self._lock:
                self._publishers[topic] = made
                self._users[topic] = 1
            return made

    def _take(self, topic: str) -> rosproto.Publisher | None:
        with self._lock:
            made = self._publishers.get(topic)
            if made is not None:
                self._users[topic] += 1
            return made

    def release(self, topic: str) -> None:
        """Give a publisher back, after its last message; the last user takes it off the graph.

        That is done in a thread, since the master may be slow. Never raises.
        """
        with self._lock:
            self._users[topic] = max(0, self._users[topic] - 1)
        self._close_unused(topic)

    def _close_unused(self, topic: str) -> None:
        with self._lock:
            if self._users[topic] or topic in self._zero_due:
                return
            publisher = self._publishers.pop(topic, None)
        if publisher is None:
            return
        try:
            threading.Thread(target=_close, args=(publisher,), name="woosh:release", daemon=True).start()
        except RuntimeError:  # the interpreter ends: closing the node takes it back
            logger.debug("! %s: no thread any more to take it back", topic)

    def _reconnected(self, topic: str) -> None:
        if topic in self._zero_due:
            self.zero(topic)
            with self._lock:
                self._zero_due.discard(topic)
            self._close_unused(topic)

    def zero_is_due(self, topic: str) -> None:
        """Let a subscriber that connects again get a zero first."""
        with self._lock:
            self._zero_due.add(topic)

    def publish(self, topic: str, velocity: Velocity) -> None:
        """Send one velocity to whoever is connected."""
        publisher = self._publishers.get(topic)
        if publisher is not None and not publisher.closed:
            publisher.publish(twist(velocity))

    def zero(self, topic: str) -> None:
        """Send zero; never raises, as it is the last resort when something else has failed."""
        try:
            self.publish(topic, Velocity())
        except Exception as error:  # a closed node, an interpreter that is shutting down
            logger.debug("! %s: zero not sent: %s", topic, error)

    @property
    def in_use(self) -> set[str]:
        """Topics that somebody drives on, or that a zero is due on."""
        with self._lock:
            return self._zero_due | {topic for topic, users in self._users.items() if users}

    def zero_from_elsewhere(self, topics: set[str]) -> None:
        """Send zero from another node, for a moment: never raises, as `zero`.

        When another node takes our name, a master may tell those who listen to us that we are gone; then they
        have ended the links before our own zeros were read.
        """
        try:
            with self._connection.new_node() as node:
                listened = [
                    node.publisher(topic, message_type(row(topic).type), queue_size=_ZEROS, linger=False)
                    for topic in sorted(topics)
                ]
                for publisher in listened:
                    publisher.wait_for_connection(timeout=_ELSEWHERE)
                    for _ in range(_ZEROS):
                        publisher.publish(twist(Velocity()))
                    publisher.flush(_FLUSH)
                    _see_arrive(publisher)
        except RosError as error:
            logger.warning("! zero was not sent once more, the robot may still be driving: %s", error)

    def flush(self, topic: str) -> None:
        """Wait a moment until what was sent is on the robot; never raises, as `zero`."""
        publisher = self._publishers.get(topic)
        if publisher is not None:
            _flush(publisher)


def _flush(publisher: rosproto.Publisher) -> None:
    try:
        if not publisher.closed:
            publisher.flush(_FLUSH)
            _see_arrive(publisher)
    except RosError as error:
        logger.debug("! %s: not flushed: %s", publisher.topic, error)


def _see_arrive(publisher: rosproto.Publisher) -> None:
    """Wait for the zeros to be on the robot before anybody tells it that we are gone.

    The robot then ends the link and reads no more: zeros that a lossy network repeats would be too late.
    """
    if publisher.wait_arrived(_ARRIVE) is False:
        logger.warning("! %s: the robot has not acknowledged the zeros yet", publisher.topic)


def _close(publisher: rosproto.Publisher) -> None:
    _flush(publisher)
    try:
        publisher.close()
    except RosError as error:
        logger.debug("! %s: not taken back: %s", publisher.topic, error)
