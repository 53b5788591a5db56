"""Our publishers of the velocity topics; they are registered only while a drive or a stop uses them.

Other programs assume that a registered publisher can drive the base (`other_drivers`), so it is unregistered
when its last user is done. After a lost link it stays until a zero was sent.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable

import rosproto
from rosproto.codec import encode
from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.watchdog import ROUNDS
from woosh_pure.connection.connection import Connection, FinalMessage, has_arrived
from woosh_pure.geometry import Velocity
from woosh_pure.interface.table import row
from woosh_pure.values.messages import message_type, twist

VELOCITY_TOPICS = {"smooth": "/smooth_cmd_vel", "direct": "/base_cmd_vel"}
logger = get_logger("woosh_pure.velocity")


class VelocityTopics:
    """Publishers of the velocity topics, counted by use. Safe from any thread.

    Args:
        connection: Its node makes them.
        heard_since: Return whether the robot was heard after a time of the monotonic clock.
        unused: Called with a topic when no drive uses it any more and no zero is due.
    """

    def __init__(
        self,
        connection: Connection,
        heard_since: Callable[[float], bool] = lambda moment: True,
        *,
        unused: Callable[[str], object] = lambda topic: None,
    ) -> None:
        self._unused = unused
        self._heard_since = heard_since
        self._asked: dict[str, float] = {}  # topic -> time of the first zero that was due
        self._connection = connection
        self._lock = threading.RLock()  # never held during network waits
        self._making = threading.RLock()
        self._publishers: dict[str, rosproto.Publisher] = {}
        self._users: Counter[str] = Counter()
        self._zero_due: set[str] = set()
        self._zero = b""

    def acquire(self, topic: str) -> rosproto.Publisher:
        """Return the publisher of a topic, until `release`.

        It has a queue of one, is not latched, and delivers nothing after the program was killed, so that no
        old velocity can be sent.

        Raises:
            RosError: It cannot be registered.
        """
        made = self._take(topic)  # does not wait: `stop` must not wait for a verb that is connecting
        if made is not None:
            return made
        with self._making:
            made = self._take(topic)
            if made is not None:
                return made
            self._zero = encode(twist(Velocity()))
            made = self._connection.open_node().publisher(
                topic,
                message_type(row(topic).type),
                queue_size=1,
                latch=False,
                linger=False,  # messages of a killed program must not arrive later
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
        """Release a publisher after its last message; the last release unregisters it.

        That is done in a thread, because the master may be slow. Never raises.
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
        self._unused(topic)
        try:
            threading.Thread(target=_close, args=(publisher,), name="woosh:release", daemon=True).start()
        except RuntimeError:  # the interpreter ends: closing the node unregisters it
            logger.debug("! %s: no thread any more to take it back", topic)

    def _reconnected(self, topic: str) -> None:
        if topic in self._zero_due:
            self.zero(topic)  # `send_due_zeros` sees whether it arrives

    def zero_is_due(self, topic: str) -> None:
        """Send zero until it has arrived; a subscriber that reconnects receives it first."""
        with self._lock:
            self._zero_due.add(topic)
            self._asked.pop(topic, None)

    @property
    def zeros_due(self) -> bool:
        """Whether a zero is due on some topic; does not wait."""
        return bool(self._zero_due)

    def send_due_zeros(self) -> None:
        """Send the zeros that are due, and remove those that have arrived."""
        for topic in list(self._zero_due):
            publisher = self._publishers.get(topic)
            if publisher is not None and not publisher.closed:
                if not publisher.connections:
                    continue  # `_reconnected` will send it
                self.zero(topic)
                if not self._has_arrived(publisher):
                    continue
            self._zero_is_there(topic)

    def _has_arrived(self, publisher: rosproto.Publisher) -> bool:
        arrived = has_arrived(publisher)
        if arrived is not None:
            return arrived
        # If the system does not report arrival (Windows, macOS): the robot is heard after one was sent.
        asked = self._asked.setdefault(publisher.topic, time.monotonic())
        return self._heard_since(asked)

    def _zero_is_there(self, topic: str) -> None:
        with self._lock:
            self._zero_due.discard(topic)
            self._asked.pop(topic, None)
        self._close_unused(topic)

    def begin(self, topic: str) -> None:
        """Begin a drive; a zero that is due is sent first."""
        if topic in self._zero_due:
            self.zero(topic)
            self._zero_is_there(topic)

    def publish(self, topic: str, velocity: Velocity) -> None:
        """Send one velocity to all connected subscribers."""
        publisher = self._publishers.get(topic)
        if publisher is not None and not publisher.closed:
            publisher.publish(twist(velocity))

    def write_zero(self, topic: str) -> None:
        """Send zero, for `stopping.immediate_stop`: already encoded, without logging or waiting.

        Raises:
            RosError: It cannot be sent.
        """
        publisher = self._publishers.get(topic)
        if publisher is not None and not publisher.closed:
            publisher.publish(self._zero)

    def zero(self, topic: str) -> None:
        """Send zero; never raises: it is used when something else has failed."""
        try:
            self.write_zero(topic)
        except Exception as error:  # a closed node, an interpreter that is shutting down
            logger.debug("! %s: zero not sent: %s", topic, error)

    @property
    def final_messages(self) -> list[FinalMessage]:
        """Zeros for the topics on which a drive is open or a zero is due."""
        with self._lock:
            topics = self._zero_due | {topic for topic, users in self._users.items() if users}
        return [FinalMessage(topic, twist(Velocity()), ROUNDS) for topic in sorted(topics)]

    def end(self, topic: str) -> None:
        """End a drive that has sent its zeros: wait briefly until they arrive, else mark a zero as due.

        Never raises.
        """
        publisher = self._publishers.get(topic)
        if publisher is not None and not publisher.closed and has_arrived(publisher) is False:
            self.zero_is_due(topic)
            logger.warning("! %s: the robot has not acknowledged the zeros yet; they are repeated", topic)


def _close(publisher: rosproto.Publisher) -> None:
    if not publisher.closed:
        has_arrived(publisher)
    try:
        publisher.close()
    except RosError as error:
        logger.debug("! %s: not taken back: %s", publisher.topic, error)
