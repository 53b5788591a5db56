"""`VelocityWatchdog`: publishes clients' messages, checks velocities, and sends zero after a lost client.

A velocity is known by its md5sum, whatever the client calls its type. One with a number that is not finite,
or larger than any robot's, is refused, whatever the protocol:
robots react differently, and some drive on. Such a velocity does not keep a drive alive either.

Most robots keep driving at the last velocity. If the last velocity of a client was not zero and the client
leaves, or sends nothing for half a second, zero is published on that topic several times, unless another
client drives there. A velocity that waited in the gateway (its topic was being opened) while a zero of
another client came is not published after that zero. A zero reaches a robot that connects to the topic
only after it, too: the topic may have been opened for it.

This protects against closed pages and lost networks. It is not an emergency stop. If this process is killed,
the watchdog process (`rosproto.watchdog`), if there is one, sends the zeros.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any

from rosproto.codec import Message, decode, define, encode, message_class
from rosproto.errors import LocalProtocolError
from rosproto.logs import get_logger
from rosproto.watchdog import ROUNDS, Watch

if TYPE_CHECKING:
    from rosproto.node import Publisher
    from rosproto.time import TVal

_log = get_logger("rosproto.gateway")

_ACKERMANN = """\
float32 steering_angle
float32 steering_angle_velocity
float32 speed
float32 acceleration
float32 jerk
"""
VELOCITY_TYPES = {
    "geometry_msgs/Twist": "",
    "geometry_msgs/TwistStamped": "",
    "ackermann_msgs/AckermannDrive": _ACKERMANN,
    "ackermann_msgs/AckermannDriveStamped": f"""\
Header header
AckermannDrive drive
{"=" * 80}
MSG: ackermann_msgs/AckermannDrive
{_ACKERMANN}
{"=" * 80}
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
""",
}
"""Velocity types with their definitions, "" for a bundled one.

A message whose numbers are all zero means "stand still".
"""
HEADER = "std_msgs/Header"

SILENCE = 0.5  # seconds
OVER = 0.5  # seconds from the first zero to the last
MISSED_SECONDS = 5.0  # for which a zero is sent to subscribers that connect after it
MAX_ZEROS = 256  # topics whose newest zero is remembered
FASTEST = 1000.0  # m/s, rad/s: no robot drives faster, so a larger number is a mistake of the client


@cache
def _velocity_md5sums() -> frozenset[str]:
    return frozenset(
        (define(name, text) if text else message_class(name))._md5sum for name, text in VELOCITY_TYPES.items()
    )


def is_velocity(kind: type[Message]) -> bool:
    """Whether a message of this class keeps a robot moving until the next one.

    The md5sum decides, because a subscriber compares nothing else: a robot takes geometry_msgs/Accel, or a
    type of any other name with the fields of geometry_msgs/Twist, for a velocity. Another revision is known
    by its name.
    """
    return kind._type in VELOCITY_TYPES or kind._md5sum in _velocity_md5sums()


def _values(message: Message) -> Iterator[object]:
    """All values of a message, nested ones too, without those of headers."""
    for name in message.__slots__:
        value = getattr(message, name)
        if isinstance(value, Message) and value._type == HEADER:
            continue
        yield from _values_in(value)


def _values_in(value: object) -> Iterator[object]:
    if hasattr(value, "tolist"):  # numpy's
        value = value.tolist()
    if isinstance(value, Message):
        yield from _values(value)
    elif isinstance(value, (list, tuple, bytes)):
        for item in value:
            yield from _values_in(item)
    else:
        yield value


def moves(message: Message) -> bool:
    """Whether any number of a velocity is not zero, its header aside."""
    return any(value != 0 for value in _values(message))


def _refuse_no_velocity(topic: str, message: Message) -> None:
    """
    Raises:
        LocalProtocolError: A number is not finite, or larger than any robot's.
    """
    for value in _values(message):
        if isinstance(value, (int, float)):
            if not math.isfinite(value):
                raise LocalProtocolError(
                    f"a velocity for {topic} is not published: it has numbers that are not finite"
                )
            if abs(value) > FASTEST:
                raise LocalProtocolError(
                    f"a velocity for {topic} is not published: it has {value:g}, which is larger than "
                    f"{FASTEST:g} m/s or rad/s"
                )


@dataclass(slots=True)
class _Topic:
    """One velocity topic.

    Attributes:
        drivers: Clients whose last velocity was not zero, with its time.
        zeros_left: Zeros still to be sent.
        next_zero: Time of the next zero.
    """

    drivers: dict[Hashable, float] = field(default_factory=dict)
    zeros_left: int = 0
    next_zero: float = 0.0


class DriveTable:
    """Which clients drive on which topics, and which zeros are due. Pure: callers pass the time.

    Args:
        silence: Seconds without a velocity after which a driver counts as gone.
        over: Seconds from the first zero to the last (`ROUNDS` of them).
    """

    def __init__(self, *, silence: float = SILENCE, over: float = OVER) -> None:
        self._silence = silence
        self._apart = over / max(1, ROUNDS - 1)
        self._topics: dict[str, _Topic] = {}

    @property
    def driven(self) -> tuple[str, ...]:
        """Topics with a driver or with zeros still to be sent."""
        return tuple(self._topics)

    def note(self, client: Hashable, topic: str, now: float, *, moving: bool) -> None:
        """Record a velocity that a client has published."""
        state = self._topics.get(topic)
        if moving:
            if state is None:
                state = self._topics[topic] = _Topic()
            state.drivers[client] = now
            state.zeros_left = 0  # a client drives: no zeros in between
        elif state is not None and state.drivers.pop(client, None) is not None and not state.drivers:
            del self._topics[topic]  # the client has stopped

    def gone(self, client: Hashable, now: float, topic: str | None = None) -> None:
        """Record that a client has left, or has stopped publishing on `topic`."""
        for name, state in self._topics.items():
            if topic in (None, name) and state.drivers.pop(client, None) is not None:
                self._stop_if_nobody_drives(state, now)

    def all_gone(self, now: float) -> None:
        """Record that all clients have left."""
        for state in self._topics.values():
            if state.drivers:
                state.drivers.clear()
                self._stop_if_nobody_drives(state, now)

    def _stop_if_nobody_drives(self, state: _Topic, now: float) -> None:
        if not state.drivers:
            state.zeros_left, state.next_zero = ROUNDS, now

    def due(self, now: float) -> list[str]:
        """Return the topics that need a zero now; each call counts as one zero of each."""
        found = []
        for name, state in list(self._topics.items()):
            silent = [client for client, last in state.drivers.items() if now - last >= self._silence]
            for client in silent:
                del state.drivers[client]
            if silent:
                self._stop_if_nobody_drives(state, now)
            if state.zeros_left and now >= state.next_zero:
                found.append(name)
                state.zeros_left -= 1
                state.next_zero = now + self._apart
            if not state.drivers and not state.zeros_left:
                del self._topics[name]
        return found

    def next_look(self) -> float | None:
        """The earliest time at which `due` may return a topic; None while no client drives."""
        times = [last + self._silence for state in self._topics.values() for last in state.drivers.values()]
        times += [state.next_zero for state in self._topics.values() if state.zeros_left]
        return min(times, default=None)


class VelocityWatchdog:
    """Publishes for the clients of one gateway, and zeros after them.

    Its thread runs only while a client drives.

    Args:
        stamp: Returns the time for zeros that have a header; None leaves it at 0.
        table: The drivers; tests pass a table with other times.
    """

    def __init__(self, stamp: Callable[[], TVal] | None = None, table: DriveTable | None = None) -> None:
        self._stamp = stamp
        self._table = table or DriveTable()
        self._changed = threading.Condition()
        self._publishers: dict[str, Publisher] = {}
        self._frames: dict[str, str] = {}
        self._watches: dict[str, Watch] = {}
        self._zeros_received: dict[str, float] = {}  # when the newest zero of each topic came
        self._thread: threading.Thread | None = None
        self._closed = False
        self.zeros = 0
        """Number of zeros sent for clients."""

    def watch(self, topic: str, watch: Watch) -> None:
        """Arm this watch of the watchdog process whenever a client drives on a topic."""
        with self._changed:
            self._watches[topic] = watch

    def unwatch(self, topic: str) -> None:
        """Drop the watch of a topic without publishers."""
        with self._changed:
            watch = self._watches.pop(topic, None)
        if watch is not None:
            watch.drop()

    def publish(
        self,
        client: Hashable,
        publisher: Publisher,
        message: Message | bytes,
        received: float | None = None,
    ) -> None:
        """Publish a client's message, and watch the client if it is a velocity.

        Args:
            client: The client.
            publisher: Must stay open for a second after the client has gone.
            message: A message, or its encoded bytes.
            received: When it came, by `time.monotonic()`; None means now.

        Raises:
            CodecError: The bytes are not a message of that type.
            LocalProtocolError: The publisher is closed; or a velocity is not finite, too large, or older than
                a zero that was published.
        """
        if not is_velocity(publisher.message_class):
            publisher.publish(message)
            return
        if not isinstance(message, Message):
            message = decode(publisher.message_class, bytes(message))
        _refuse_no_velocity(publisher.topic, message)
        moving = moves(message)
        with self._changed:  # published and recorded in the same order
            topic = publisher.topic
            received = time.monotonic() if received is None else received
            if moving and self._closed:
                return  # no zero would follow
            if moving and received < self._zeros_received.get(topic, 0.0):
                raise LocalProtocolError(
                    f"a velocity for {topic} is not published: a zero was received while it waited"
                )
            if not moving:
                self._note_zero(topic, received)
            if moving:
                self._publishers[topic] = publisher
                header = getattr(message, "header", None)
                self._frames[topic] = getattr(header, "frame_id", "")
                self._arm(topic, publisher)
                self._start()
            publisher.publish(message)
            self._table.note(client, topic, time.monotonic(), moving=moving)
            self._disarm()

    def connected(self, publisher: Publisher, caller_id: str) -> None:
        """A subscriber has connected: send it the zero that it has missed, unless a client drives now."""
        topic = publisher.topic
        with self._changed:
            recent = time.monotonic() - self._zeros_received.get(topic, -math.inf) <= MISSED_SECONDS
            if recent and topic not in self._table.driven:
                publisher.publish_to(caller_id, encode(self._zero(topic, publisher)))

    def _note_zero(self, topic: str, received: float) -> None:
        """Called with the lock held."""
        newest = max(received, self._zeros_received.pop(topic, 0.0))
        if len(self._zeros_received) >= MAX_ZEROS:
            del self._zeros_received[next(iter(self._zeros_received))]
        self._zeros_received[topic] = newest

    def gone(self, client: Hashable, topic: str | None = None) -> None:
        """A client has left, or stopped publishing on a topic: send zero now where it drove."""
        with self._changed:
            now = time.monotonic()
            self._table.gone(client, now, topic)
            self._send(now)
            self._changed.notify_all()

    def close(self) -> None:
        """Send zeros on all driven topics (half a second), and accept no more velocities."""
        with self._changed:
            self._closed = True
            self._table.all_gone(time.monotonic())
            self._changed.notify_all()
            thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(2 * OVER + 1.0)

    def _start(self) -> None:
        """Start the thread before something moves, because without it no zero would follow; lock held.

        Raises:
            RuntimeError: The system gives no more threads.
        """
        if self._thread is None:
            thread = threading.Thread(target=self._run, name="rosproto:velocity watchdog", daemon=True)
            thread.start()
            self._thread = thread

    def _arm(self, topic: str, publisher: Publisher) -> None:
        """Called with the lock held, before a moving velocity is published."""
        watch = self._watches.get(topic)
        if watch is not None and not watch.armed:
            watch.arm(encode(self._zero(topic, publisher)))

    def _disarm(self) -> None:
        """Called with the lock held."""
        driven = self._table.driven
        for topic, watch in self._watches.items():
            if watch.armed and topic not in driven:
                watch.disarm()

    def _run(self) -> None:
        with self._changed:
            while (look := self._table.next_look()) is not None:
                wait = look - time.monotonic()
                if wait > 0.0:
                    self._changed.wait(wait)
                self._send(time.monotonic())
            self._thread = None
            self._publishers.clear()
            self._frames.clear()

    def _send(self, now: float) -> None:
        """Called with the lock held."""
        for topic in self._table.due(now):
            publisher = self._publishers[topic]
            try:
                publisher.publish(self._zero(topic, publisher))
                self.zeros += 1
            except Exception as error:  # the node is closed, so zero cannot be sent any more
                _log.warning("! %s: zero could not be published after its client left: %s", topic, error)
        self._disarm()

    def _zero(self, topic: str, publisher: Publisher) -> Any:
        zero: Any = publisher.message_class()
        if publisher.message_class._has_header:
            zero.header.frame_id = self._frames.get(topic, "")
            if self._stamp is not None:
                zero.header.stamp = self._stamp()
        return zero
