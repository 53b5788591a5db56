"""A feed: one topic that the chassis publishes, subscribed on first use, with one interface for all topics.

`Feeds` has the feeds of one chassis, and the waits on them.

Ages are measured by our own clock at receipt, so the robot's clock need not agree with ours. The message's
own stamp is available, too.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rosproto import Node, Subscriber
from rosproto.codec import decoder
from rosproto.coercion import require_callback
from rosproto.errors import ConnectionLost, LocalProtocolError, RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.node import ConnectedLink, fresh_messages
from rosproto.sentence import both, say
from rosproto.transport import Deadline
from woosh_pure.connection.arguments import require_timeout
from woosh_pure.connection.connection import Connection
from woosh_pure.errors import StaleState
from woosh_pure.feed.type_adapter import TypeAdapter
from woosh_pure.geometry import Velocity
from woosh_pure.hints import FEED, Hints, refusing
from woosh_pure.interface import find, row
from woosh_pure.interface.schema import Row
from woosh_pure.values.convert import prepare, stamp_of, to_value
from woosh_pure.values.messages import message_type

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)
logger = get_logger("woosh_pure.feed")

FIRST_USE = 1.0
"""Longest wait of a feed's first reading for its links, s; usually they are up much sooner."""
_CLOSED = "{topic}: this feed is closed, because its Chassis is; open a new one"
_LATCHED = 0.3  # seconds from the link until a latching publisher has sent its value
PICTURES = ("sensor_msgs/Image", "sensor_msgs/PointCloud2", "nav_msgs/OccupancyGrid")
"""Types whose messages are so large (a cloud has 5 MB) that only a few are kept."""
_HISTORY, _HISTORY_OF_PICTURES = 100, 3
_SLICE = 0.1  # waits are cut into slices: on Windows, Ctrl-C cannot interrupt a wait for a lock
_QUEUE, _QUEUE_ON_CHANGE = 10, 1000  # messages sent on change only must not be dropped for newer ones


@dataclass(frozen=True, slots=True)
class Reading(Generic[T_co]):
    """One received value.

    Attributes:
        value: The value.
        received: Our monotonic clock at receipt, s.
        stamp: The message's own stamp, s since 1970 by the sender's clock; None when it has none.
        message: The message itself.
    """

    value: T_co
    received: float
    stamp: float | None
    message: Any

    @property
    def age(self) -> float:
        """Return the seconds since receipt, by our clock."""
        return time.monotonic() - self.received


class Newest(Hints, Generic[T]):
    """What a feed says of its newest reading, whether it is awaited or not."""

    _hints = FEED

    @property
    def reading(self) -> Reading[T] | None:
        """The newest reading, None when nothing was heard yet."""
        raise NotImplementedError

    @property
    def latest(self) -> T | None:
        """The newest value, None when nothing was heard yet."""
        reading = self.reading
        return None if reading is None else reading.value

    @property
    def age(self) -> float | None:
        """Seconds since the newest value by our clock, None when nothing was heard yet."""
        reading = self.reading
        return None if reading is None else reading.age

    @property
    def heard(self) -> bool:
        """True when at least one value has come."""
        return self.reading is not None

    if not TYPE_CHECKING:
        __call__ = refusing("{kind!r} object is not callable; use .wait(timeout=5), or .latest")


class Feed(Newest[T]):
    """Newest value, waiting, iterating and callbacks for one topic.

    The first use subscribes and waits until the publishers are connected (a few hundredths of a second, at
    most `FIRST_USE`): from then on no message is missed, and a latched value has arrived. If the topic has no
    publisher, there is no wait. Before the first message `latest`, `age` and `reading` are None.
    Messages of several publishers are merged in the order of arrival. Callbacks run in the receiving thread
    of the link: keep them short, and do not wait for the same topic in them. An exception in a callback is
    logged and does not affect the others.

    Attributes:
        row: The row of the interface table.
        links: The connections to publishers that are up now; one that was made again is another one.
    """

    def __init__(self, row: Row, node: Callable[[], Node]) -> None:
        self._kept = _HISTORY_OF_PICTURES if row.type in PICTURES else _HISTORY
        self.row = row
        self.links: frozenset[ConnectedLink] = frozenset()
        self._node = node
        # Reentrant, like every lock that `close` takes: a Ctrl-C at its end leaves it held by the thread that
        # then closes. Reading does not take it: a stop in a signal handler must see new values while the
        # interrupted frame waits here.
        self._open_lock = threading.RLock()
        self._receiving = threading.Lock()  # taken by receiving threads only
        # Numbered from 1. A new tuple each time: without the GIL a deque cannot be copied while it grows.
        self._history: tuple[tuple[int, Reading[T]], ...] = ()
        self._waiting: list[threading.Lock] = []
        self._links_then: frozenset[ConnectedLink] = frozenset()
        self._callbacks: list[Callable[[T], object]] = []
        self._calling: set[int] = set()
        self._subscriber: Subscriber | None = None
        self._settled = False
        self._closed = False

    def __repr__(self) -> str:
        newest = self.known
        heard = "not heard yet" if newest is None else f"{self.count} heard, age {newest.age:.2f} s"
        return f"<Feed {self.row.name} {self.row.type}: {heard}; see .wait(timeout=5) and .latest>"

    @property
    def topic(self) -> str:
        """Name of the topic."""
        return self.row.name

    def open(self) -> Feed[T]:
        """Subscribe now and return this feed at once; `wait_connected` waits for the links.

        Every other member does both. To use several feeds, open them all first, so that they connect at the
        same time.

        Raises:
            ConnectionLost: The Chassis is closed, and nothing was ever received here.
        """
        if self._subscriber is not None:
            return self
        with self._open_lock:
            if self._closed and not self._history:
                raise ConnectionLost(say(_CLOSED, topic=self.topic))
            if self._subscriber is None and not self._closed:
                self._subscriber = self._subscribe(self._node())
        return self

    def _subscribe(self, node: Node) -> Subscriber:
        name, size = self.row.name, _QUEUE_ON_CHANGE if self.row.on_change else _QUEUE
        if not self.row.definition_known:
            return node.subscriber(
                name, None, callback=self._receive, on_links=self._note_links, queue_size=size
            )
        ours = message_type(self.row.type)
        decoder(ours)
        prepare(self.row.type, ours())
        try:
            return node.subscriber(
                name, ours, callback=self._receive, on_links=self._note_links, queue_size=size
            )
        except LocalProtocolError:  # the program has opened it with a definition of its own
            reading = TypeAdapter(ours, node, self._receive)
            return node.subscriber(
                name, None, callback=reading, on_links=self._note_links, queue_size=size, raw=True
            )

    def _note_links(self, links: frozenset[ConnectedLink]) -> None:
        self.links = links

    def wait_connected(self, timeout: float = FIRST_USE) -> bool:
        """Wait until each publisher the master lists is connected or has failed, latched values included.

        Returns:
            True when at least one publisher is connected.
        """
        subscriber = self.open()._subscriber
        if subscriber is None:
            return False
        deadline = Deadline(timeout)
        # A publisher that cannot be reached is retried in the background; this does not wait for it.
        while any(not (link.connected or link.last_error) for link in subscriber.stats()):
            if self._closed or deadline.expired:
                break
            time.sleep(0.002)
        deadline = deadline.at_most(_LATCHED)
        while subscriber.latching and not self._history and not self._closed and not deadline.expired:
            time.sleep(0.002)
        self._settled = True
        return subscriber.connections > 0

    def connect(self) -> None:
        """Subscribe; the first time, wait until the links are up, except in a callback of this feed."""
        if self._settled and self._subscriber is not None:
            return
        if self._closed or threading.get_ident() in self._calling:
            self.open()
        else:
            self.wait_connected()

    def close(self) -> None:
        """End the subscription and wake all waiting threads. What was heard can still be read."""
        with self._open_lock:
            self._closed = True
            subscriber, self._subscriber = self._subscriber, None
        self._wake()
        if subscriber is not None:
            subscriber.close()
        self.links = frozenset()

    def _receive(self, message: Any) -> None:
        received = time.monotonic()
        try:
            value = to_value(self.row.type, message)
        except ValueError as error:
            logger.warning("%s: a message makes no sense and is left out: %s", self.row.name, error)
            return
        reading = Reading(value, received, stamp_of(message), message)
        with self._receiving:
            self._links_then = self.links
            # The newest `_kept - 1` and this one.
            self._history = (*self._history[1 - self._kept :], (self.count + 1, reading))
        callbacks = list(self._callbacks)
        self._wake()
        if not callbacks:
            return
        me = threading.get_ident()
        self._calling.add(me)
        try:
            for callback in callbacks:
                call_back(callback, value, self.row.name)
        finally:
            self._calling.discard(me)

    def _wake(self) -> None:
        """Wake all waiting threads."""
        for news in list(self._waiting):
            try:
                news.release()
            except RuntimeError:
                pass  # it is open already

    @contextmanager
    def _news(self) -> Iterator[threading.Lock]:
        """A lock that is released for new values, and when the feed is closed."""
        news = threading.Lock()
        news.acquire()
        self._waiting.append(news)
        try:
            yield news
        finally:
            self._waiting.remove(news)

    @property
    def in_callback(self) -> bool:
        """True in a callback of this feed, where the next value cannot come before the callback returns."""
        return threading.get_ident() in self._calling

    @property
    def known(self) -> Reading[T] | None:
        """As `reading`, but neither subscribes nor waits; also None when this feed was never used."""
        return self._history[-1][1] if self._history else None

    @property
    def reading(self) -> Reading[T] | None:
        """The newest reading, None when nothing was heard yet."""
        self.connect()
        return self.known

    @property
    def opened(self) -> bool:
        """True when it is subscribed, or closed for good."""
        return self._subscriber is not None or self._closed

    @property
    def known_history(self) -> tuple[Reading[T], ...]:
        """As `history`, but neither subscribes nor waits."""
        return tuple(reading for _, reading in self._history)

    @property
    def closed(self) -> bool:
        """True when nothing will come any more: the Chassis is closed, or its node is."""
        subscriber = self._subscriber
        return self._closed or (subscriber is not None and subscriber.closed)

    @property
    def count(self) -> int:
        """Values received so far."""
        return self._history[-1][0] if self._history else 0

    @property
    def publishers(self) -> int:
        """Publishers connected now."""
        return len(self.open().links)

    @property
    def sources(self) -> frozenset[str]:
        """Addresses ("host:port") of the publishers connected now; a new address means a new process."""
        return frozenset(link.address for link in self.links)

    @property
    def unreachable(self) -> str:
        """Why none of its publishers is connected although the master lists some; "" otherwise."""
        subscriber = self._subscriber
        if subscriber is None or subscriber.connections or not subscriber.stats():
            return ""
        return subscriber.why_silent()

    @property
    def outdated(self) -> bool:
        """True when the last value of a topic sent only on change may be out of date: its link has broken
        since, so a change may have been missed.
        """
        return self.row.on_change and bool(self._history) and (self._closed or self.links != self._links_then)

    @property
    def errors(self) -> list[Exception]:
        """The last few errors on its links: refused by a publisher, connection lost ..."""
        subscriber = self._subscriber
        return [] if subscriber is None else subscriber.errors

    @property
    def history(self) -> tuple[Reading[T], ...]:
        """The last readings, oldest first: 100 of them, or 3 for pictures and point clouds."""
        self.connect()
        return self.known_history

    def on(self, callback: Callable[[T], object], *, connect: bool = True) -> Callable[[], None]:
        """Call `callback(value)` for each new value; returns a function that ends this.

        Args:
            callback: Called in the receiving thread.
            connect: False does not wait for the links.

        Raises:
            ConnectionLost: The Chassis is closed.
        """
        self.require_open()

        def off() -> None:
            if callback in self._callbacks:
                self._callbacks.remove(callback)

        self._callbacks.append(require_callback(callback))
        try:
            if connect:
                self.connect()
            else:
                self.open()
        except BaseException:
            off()
            raise
        return off

    def wait(self, timeout: float | None = 5.0, *, new: bool = True) -> T:
        """The next value.

        Args:
            timeout: Seconds; None waits for ever.
            new: False returns the newest value at once if there is one.

        Raises:
            RosTimeout: None came in time.
            ConnectionLost: The Chassis is closed, or was closed meanwhile.
            LocalProtocolError: Called in a callback of this feed, where no next value can come.
        """
        return self._first(lambda value: True, timeout, new=new)

    def wait_for(self, accept: Callable[[T], bool], timeout: float | None = 5.0) -> T:
        """The first value for which `accept` is true: the newest known one, or any that comes after it.

        Raises:
            RosTimeout: None came in time.
            ConnectionLost: The Chassis is closed, or was closed meanwhile.
            LocalProtocolError: Called in a callback of this feed, where no next value can come.
        """
        return self._first(accept, timeout, new=False)

    def _first(self, accept: Callable[[T], bool], timeout: float | None, *, new: bool) -> T:
        # Read before the topic is opened: a latched value comes only once, with its link.
        seen = self.count if new else max(0, self.count - 1)
        deadline = self._begin_wait(timeout)
        with self._news() as news:
            while True:
                while self.count <= seen:
                    self._pause(news, deadline, timeout)
                # Check every reading: the condition may have been true only for a moment.
                for number, reading in self._history:
                    if number > seen:
                        seen = number
                        if accept(reading.value):
                            return reading.value

    def _begin_wait(self, timeout: float | None) -> Deadline:
        """Check that a wait may begin, and return its deadline."""
        timeout = require_timeout(timeout)
        self.require_open()
        if self.in_callback:
            raise LocalProtocolError(
                say(
                    "{topic}: waiting for its next value in its own callback would never end; "
                    "wait in another thread",
                    topic=self.topic,
                )
            )
        self.open()
        return Deadline(timeout)

    def require_open(self) -> None:
        """Check that values can still come.

        Raises:
            ConnectionLost: The Chassis is closed, or its node is.
        """
        if self._closed:
            raise ConnectionLost(say(_CLOSED, topic=self.topic))
        subscriber = self._subscriber
        if subscriber is not None and subscriber.closed:  # by `rosnode kill`, or this is a fork
            why = self._node().close_reason
            wrong = "{topic}: the node of this Chassis is closed ({why}); open a new one"
            raise ConnectionLost(say(wrong, topic=self.topic, why=why))

    def _pause(self, news: threading.Lock, deadline: Deadline, timeout: float | None) -> None:
        """Wait for a change; raises when no more can come."""
        self.require_open()
        if deadline.expired:
            raise self.silence(timeout)
        _wait_for(news, deadline.at_most(_SLICE).remaining() or 0.0)

    def silence(self, timeout: float | None) -> RosTimeout:
        """Return the error of a wait that timed out."""
        subscriber = self._subscriber
        publishers = 0 if subscriber is None else subscriber.connections
        who = self.unreachable or say("connected publishers: {count}", count=publishers)
        if self.row.on_change:
            silent = "{topic}: nothing was received within {seconds} s (it is sent on change only)"
        else:
            silent = "{topic}: nothing was received within {seconds} s"
        text = both(say(silent, topic=self.row.name, seconds=timeout), who, "check `woosh doctor`")
        return RosTimeout(text, what=self.row.name, seconds=timeout)

    def __iter__(self) -> Iterator[T]:
        """Values as they come; a slow loop skips to the newest. Ends with the chassis, or its node."""
        self.connect()
        seen = 0
        while True:
            with self._news() as news:
                while self.count == seen and not self.closed:
                    _wait_for(news, _SLICE)
            if self.closed:
                return
            seen, reading = self._history[-1]
            yield reading.value


def call_back(callback: Callable[[T], object], value: T, what: str) -> None:
    """Call a user's callback; an exception in it is logged."""
    try:
        callback(value)
    except Exception:
        logger.exception("%s: a callback failed", what)


def _wait_for(news: threading.Lock, seconds: float) -> None:
    news.acquire(timeout=seconds)


# A link counts as lost when its publisher has been away for this long. A restart of one of the chassis's
# nodes takes about a second and is no reason to give up a task.
_LOST_AFTER = 5.0
_LOOK = 0.02  # seconds


class Feeds:
    """The feeds of one chassis: each is made on first use, all are closed by `close`. Safe from any thread.

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
        """Names of the feeds that are subscribed, or were."""
        with self._lock:
            return {name for name, feed in self._feeds.items() if feed.opened}

    def close(self) -> None:
        """End their subscriptions; may be called again."""
        with self._lock:
            feeds = list(self._feeds.values())
        for feed in feeds:
            feed.close()

    def require_publisher(self, name: str) -> None:
        """Wait until the topic that reports the end of a goal is connected.

        Raises:
            StaleState: It has no publisher, so the end of the goal could not be seen.
        """
        feed, seconds = self.get(name), self._connection.timeout
        end = time.monotonic() + seconds
        while not feed.publishers:
            if time.monotonic() >= end:
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
                    "{topic} is silent, so it could not be seen whether the robot obeys; check the chassis, "
                    "or pass feedback_timeout=None to drive without it",
                    topic=feed.topic,
                ),
                topic=feed.topic,
                age=feed.age,
            ) from error

    def lost(self, name: str) -> str:
        """Why the link of a feed counts as lost; "" while it is up."""
        feed, beat = self.get(name), self.get("velocity")
        try:
            publishers, age = feed.publishers, beat.age
        except ConnectionLost as closed:
            return str(closed)
        if publishers > 0:
            self._missing_since.pop(name, None)
        else:
            since = self._missing_since.setdefault(name, time.monotonic())
            if time.monotonic() - since > _LOST_AFTER:
                return say(
                    "{topic} has had no publisher for {seconds} s", topic=feed.topic, seconds=_LOST_AFTER
                )
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
