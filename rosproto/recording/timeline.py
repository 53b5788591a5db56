"""The messages of one or several bags in a time span, in time order, for a player."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from rosproto.bag import BagReader, Connection, RawMessage
from rosproto.errors import BagError
from rosproto.time import Time

NS = 1_000_000_000


class TimelineEntry(NamedTuple):
    """A message to play: receive time in ns since 1970, number of its bag, the message."""

    time_ns: int
    bag: int
    message: RawMessage


class Timeline:
    """The messages to play: a time span of the chosen topics of some bags.

    Args:
        bags: Open bags; the caller closes them.
        topics: Only these.
        start: Seconds after the earliest message of all bags.
        duration: Length in seconds; None plays to the end.

    Raises:
        BagError: A topic is in none of the bags.
        ValueError: `start` or `duration` is negative.

    Attributes:
        start_ns: Start of the span, ns since 1970 (0 when all bags are empty).
        end_ns: End of the span: the latest message, or earlier because of `duration`.
    """

    def __init__(
        self,
        bags: Sequence[BagReader],
        *,
        topics: Iterable[str] | None = None,
        start: float = 0.0,
        duration: float | None = None,
    ) -> None:
        if start < 0 or (duration is not None and duration < 0):
            raise ValueError(f"start {start} and duration {duration} must be seconds and not negative")
        self._bags = list(bags)
        self._topics = None if topics is None else set(topics)
        self._check_topics()
        starts = [bag.start_time.to_nsec() for bag in bags if bag.start_time is not None]
        ends = [bag.end_time.to_nsec() for bag in bags if bag.end_time is not None]
        self.start_ns = min(starts, default=0) + round(start * NS)
        self.end_ns = max(ends, default=0)
        if duration is not None:
            self.end_ns = min(self.end_ns, self.start_ns + round(duration * NS))
        self._offset = start

    @property
    def duration(self) -> float:
        """Length of the span in seconds."""
        return max(0.0, (self.end_ns - self.start_ns) / NS)

    @property
    def connections(self) -> list[tuple[int, Connection]]:
        """Every connection that may be played, with the number of its bag."""
        return [
            (number, connection)
            for number, bag in enumerate(self._bags)
            for connection in bag.connections.values()
            if self._topics is None or connection.topic in self._topics
        ]

    def __iter__(self) -> Iterator[TimelineEntry]:
        """Every message of the span, in time order."""
        streams = [self._entries(number) for number in range(len(self._bags))]
        # At equal times, bags in the order given; messages themselves cannot be compared.
        return streams[0] if len(streams) == 1 else heapq.merge(*streams, key=lambda e: (e[0], e[1]))

    def latched_before(self) -> list[TimelineEntry]:
        """Each latched connection's last message before the span, for late subscribers."""
        if not self._offset:
            return []
        found = [
            self._last_before(number, connection)
            for number, connection in self.connections
            if connection.latching
        ]
        return sorted((entry for entry in found if entry is not None), key=lambda e: e[:2])

    def _entries(self, number: int) -> Iterator[TimelineEntry]:
        bag = self._bags[number]
        start, end = Time.from_nsec(self.start_ns), Time.from_nsec(self.end_ns)
        if self.end_ns < self.start_ns:
            return
        for _, message, stamp in bag.read_messages(self._topics, start, end, raw=True):
            yield TimelineEntry(stamp.to_nsec(), number, message)

    def _last_before(self, number: int, connection: Connection) -> TimelineEntry | None:
        """A connection's last message before the span; reads chunks that may hold it, the latest first."""
        bag = self._bags[number]
        limit = self.start_ns - 1
        chunks = [c for c in bag.chunks if c.counts.get(connection.id) and c.start <= limit]
        last: TimelineEntry | None = None
        for chunk in sorted(chunks, key=lambda c: c.end, reverse=True):
            if last is not None and min(chunk.end, limit) < last.time_ns:
                break
            span = Time.from_nsec(chunk.start), Time.from_nsec(min(chunk.end, limit))
            for _, message, stamp in bag.read_messages(None, *span, raw=True, connections=[connection]):
                now = stamp.to_nsec()
                if last is None or now >= last.time_ns:
                    last = TimelineEntry(now, number, message)
        return last

    def _check_topics(self) -> None:
        if self._topics is None:
            return
        known = {topic for bag in self._bags for topic in bag.topics}
        missing = sorted(self._topics - known)
        if missing:
            names, there = ", ".join(map(repr, missing)), ", ".join(sorted(known)) or "none at all"
            raise BagError(f"no messages on topic {names}; there are {there}")
