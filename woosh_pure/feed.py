"""A feed: one topic the chassis publishes, subscribed on first use, with one face for all of them.

Ages are by our receive clock, so they need no common clock with the robot; the message's own stamp stands
beside.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rosproto.errors import RosTimeout

from .convert import stamp_of, to_value
from .interface import Row

if TYPE_CHECKING:
    from rosproto import Node, Subscriber

__all__ = ["Feed", "Reading"]

T = TypeVar("T")
logger = logging.getLogger("woosh_pure.feed")


@dataclass(frozen=True, slots=True)
class Reading(Generic[T]):
    """One received value.

    Attributes:
        value: The value.
        received: Our monotonic clock at receipt, s.
        stamp: The message's own stamp, s since 1970 by the sender's clock; None when it has none.
        message: The message itself.
    """

    value: T
    received: float
    stamp: float | None
    message: Any

    @property
    def age(self) -> float:
        """Seconds since receipt, by our clock."""
        return time.monotonic() - self.received


class Feed(Generic[T]):
    """Newest value, waiting, iterating and callbacks for one topic.

    "Not heard yet" is a value: `latest`,"
    " `age` and `reading` are None then. Several publishers on the topic are
    merged in the order of arrival. Callbacks run in the receiving thread of the link: keep them short; an
    exception in one is logged and harms nobody else.

    Attributes:
        row: The row of the interface table.
    """

    def __init__(self, row: Row, node: Callable[[], Node], *, history: int = 100) -> None:
        self.row = row
        self._node = node
        self._condition = threading.Condition()
        self._open_lock = threading.Lock()  # apart from the condition: messages come while we still register
        self._history: deque[Reading[T]] = deque(maxlen=history)
        self._count = 0
        self._broken = 0
        self._callbacks: list[Callable[[T], object]] = []
        self._subscriber: Subscriber | None = None
        self._closed = False

    def __repr__(self) -> str:
        newest = self._history[-1] if self._history else None
        heard = "not heard yet" if newest is None else f"{self._count} heard, age {newest.age:.2f} s"
        return f"<Feed {self.row.name} {self.row.type}: {heard}>"

    @property
    def topic(self) -> str:
        """Name of the topic."""
        return self.row.name

    def open(self) -> Feed[T]:
        """Subscribe now; every other member does it by itself. Returns this feed."""
        with self._open_lock:
            if self._subscriber is None and not self._closed:
                self._subscriber = self._node().subscriber(
                    self.row.name, self.row.type, callback=self._receive, queue_size=10
                )
        return self

    def close(self) -> None:
        """End the subscription and wake everybody who waits."""
        with self._open_lock:
            self._closed = True
            subscriber, self._subscriber = self._subscriber, None
        with self._condition:
            self._condition.notify_all()
        if subscriber is not None:
            subscriber.close()

    def _receive(self, message: Any) -> None:
        received = time.monotonic()
        try:
            value = to_value(self.row.type, message)
        except ValueError as error:
            self._broken += 1
            logger.warning("%s: a message makes no sense and is left out: %s", self.row.name, error)
            return
        reading = Reading(value, received, stamp_of(message), message)
        with self._condition:
            self._history.append(reading)
            self._count += 1
            callbacks = list(self._callbacks)
            self._condition.notify_all()
        for callback in callbacks:
            try:
                callback(value)
            except Exception:
                logger.exception("%s: a callback failed", self.row.name)

    @property
    def reading(self) -> Reading[T] | None:
        """The newest reading, None when nothing was heard yet."""
        self.open()
        with self._condition:
            return self._history[-1] if self._history else None

    @property
    def latest(self) -> T | None:
        """The newest value, None when nothing was heard yet."""
        reading = self.reading
        return None if reading is None else reading.value

    @property
    def age(self) -> float | None:
        """Seconds since the newest value by our clock, None when nothing was heard yet."""
        newest = self.reading
        return None if newest is None else newest.age

    @property
    def heard(self) -> bool:
        """True when at least one value has come."""
        return self.reading is not None

    @property
    def count(self) -> int:
        """Values received so far."""
        return self._count

    @property
    def publishers(self) -> int:
        """Publishers connected now."""
        self.open()
        return 0 if self._subscriber is None else self._subscriber.connections

    @property
    def errors(self) -> list[Exception]:
        """What went wrong on its links, the last few: refused by a publisher, lost ..."""
        return [] if self._subscriber is None else self._subscriber.errors

    @property
    def history(self) -> tuple[Reading[T], ...]:
        """The last readings, oldest first."""
        self.open()
        with self._condition:
            return tuple(self._history)

    def on(self, callback: Callable[[T], object]) -> Callable[[], None]:
        """Call `callback(value)` for each new value; returns a function that ends it."""
        with self._condition:
            self._callbacks.append(callback)
        self.open()

        def off() -> None:
            with self._condition:
                if callback in self._callbacks:
                    self._callbacks.remove(callback)

        return off

    def wait(self, timeout: float | None = 5.0, *, new: bool = True) -> T:
        """The next value.

        Args:
            timeout: Seconds; None waits for ever.
            new: False returns a value at once when one was heard before.

        Raises:
            RosTimeout: None came in time.
        """
        self.open()
        deadline = None if timeout is None else time.monotonic() + timeout
        with self._condition:
            before = self._count if new else 0
            while self._count <= before:
                rest = None if deadline is None else deadline - time.monotonic()
                if self._closed or (rest is not None and rest <= 0.0):
                    raise self._silence(timeout)
                self._condition.wait(rest)
            return self._history[-1].value

    def wait_for(self, accept: Callable[[T], bool], timeout: float | None = 5.0) -> T:
        """The first value that `accept` likes, the newest known one included.

        Raises:
            RosTimeout: None came in time.
        """
        self.open()
        deadline = None if timeout is None else time.monotonic() + timeout
        seen = -1
        with self._condition:
            while True:
                if self._count != seen and self._history:
                    seen = self._count
                    value = self._history[-1].value
                    if accept(value):
                        return value
                rest = None if deadline is None else deadline - time.monotonic()
                if self._closed or (rest is not None and rest <= 0.0):
                    raise self._silence(timeout)
                self._condition.wait(rest)

    def _silence(self, timeout: float | None) -> RosTimeout:
        why = "the feed was closed" if self._closed else f"nothing came within {timeout} s"
        hint = " (it is sent on change only)" if self.row.on_change else ""
        publishers = 0 if self._subscriber is None else self._subscriber.connections
        return RosTimeout(
            f"{self.row.name}: {why}{hint}; {publishers} publishers are connected; check `woosh doctor`",
            what=self.row.name,
            seconds=timeout,
        )

    def __iter__(self) -> Iterator[T]:
        """Values as they come; a slow loop skips to the newest. Ends when the chassis is closed."""
        self.open()
        seen = 0
        while True:
            with self._condition:
                while self._count == seen and not self._closed:
                    self._condition.wait()
                if self._closed:
                    return
                seen = self._count
                value = self._history[-1].value
            yield value
