"""Recorder: topics of a live graph into bags, without decoding anything.

Messages arrive in the node's threads and are put into a buffer of bounded size; one thread writes. A
message is stored with its publisher's own type, md5sum, definition and caller id, under the time it was
received.
"""

from __future__ import annotations

import logging
import re
import threading
from collections import deque
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from rosproto.bag import BagWriter, Connection, RawMessage
from rosproto.errors import RosError
from rosproto.time import Time

if TYPE_CHECKING:
    from types import TracebackType

    from rosproto.node import Node

__all__ = ["Recorder"]

_log = logging.getLogger("rosproto.recording")
_LOOK_SECONDS = 1.0
_QUEUE = 10_000

Item = tuple[str, RawMessage, Time]


class Recorder:
    """Records until closed. Use it in a `with` block.

    Args:
        node: The node to subscribe with.
        path: The bag; with splitting, `name_0.bag`, `name_1.bag` and so on.
        topics: These, also before they are published.
        pattern: And every published topic that this regular expression matches wholly, looked for every
        second. exclude: But none that this one matches wholly.
        compression, chunk_bytes: As for `BagWriter`.
        split_bytes: Begin a new bag when one has reached this size.
        split_seconds: Begin a new bag when one covers this span.
        limit: Record at most so many messages of each topic.
        buffer_bytes: Messages waiting for the disk; what comes when it is full is dropped and counted.

    Raises:
        BagError: The file cannot be opened.
        ValueError: A pattern is not a regular expression, or nothing was asked for.

    Attributes:
        paths: Bags written so far, the one being written last.
        messages: Messages taken.
        bytes: Their size.
        dropped: Messages lost because the buffer was full.
        error: What ended the recording early (a full disk), None while all is well; `close` raises it.
    """

    def __init__(
        self,
        node: Node,
        path: str | Path,
        topics: Iterable[str] = (),
        *,
        pattern: str | None = None,
        exclude: str | None = None,
        compression: Literal["none", "bz2", "lz4"] = "none",
        chunk_bytes: int = 768 * 1024,
        split_bytes: int | None = None,
        split_seconds: float | None = None,
        limit: int | None = None,
        buffer_bytes: int = 256 << 20,
    ) -> None:
        self._node = node
        self._path = Path(path)
        self._pattern, self._exclude = _compiled(pattern), _compiled(exclude)
        self._names = [node.resolve_name(topic) for topic in topics]
        if not self._names and self._pattern is None:
            raise ValueError("nothing to record: name topics, or give a pattern ('.*' for everything)")
        self._options: dict[str, Any] = {"compression": compression, "chunk_bytes": chunk_bytes}
        self._split_bytes, self._split_seconds = split_bytes, split_seconds
        self._limit, self._most = limit, buffer_bytes
        self._ready = threading.Condition()
        self._queue: deque[Item] = deque()
        self._waiting = 0
        self._ending = threading.Event()
        self._counts: dict[str, int] = {}
        self._connections: dict[tuple[str, int], tuple[Connection, dict[str, str]]] = {}
        self._latched: dict[tuple[str, str], Item] = {}
        self._subscribers: dict[str, Any] = {}
        self._first: Time | None = None
        self.paths: list[Path] = []
        self.messages = self.bytes = self.dropped = 0
        self.error: RosError | None = None
        self._closed = False
        self._writer = self._open()
        self._threads = [
            threading.Thread(target=target, name=f"rosproto:record {name}", daemon=True)
            for target, name in ((self._write_all, "writer"), (self._look, "topics"))
        ]
        for name in self._names:
            self._subscribe(name)
        for thread in self._threads:
            thread.start()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def topics(self) -> list[str]:
        """Topics subscribed now."""
        return sorted(self._subscribers)

    @property
    def waiting_bytes(self) -> int:
        """How much of the buffer is in use."""
        return self._waiting

    def close(self, timeout: float = 10.0) -> None:
        """Stop, write what waits, close the bag. May be called twice.

        Raises:
            RosError: What ended the recording early; the bag is readable up to its last whole chunk.
        """
        if self._closed:
            return
        self._closed = True
        self._ending.set()
        for subscriber in list(self._subscribers.values()):
            subscriber.close()
        with self._ready:
            self._ready.notify_all()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(timeout)
        if self.error is not None:
            raise self.error

    # -- topics ------------------------------------------------------------------------------

    def _look(self) -> None:
        """Subscribe topics as they appear; a master that is away for a while is nothing special."""
        while self._pattern is not None:
            try:
                for topic in self._node.master.get_published_topics():
                    if self._is_wanted(topic):
                        self._subscribe(topic)
            except RosError as problem:
                _log.debug("! looking for topics: %s", problem)
            if self._ending.wait(_LOOK_SECONDS):
                return

    def _is_wanted(self, topic: str) -> bool:
        assert self._pattern is not None
        excluded = self._exclude is not None and self._exclude.fullmatch(topic)
        return bool(self._pattern.fullmatch(topic)) and not excluded and topic not in self._subscribers

    def _subscribe(self, topic: str) -> None:
        self._subscribers[topic] = self._node.subscriber(
            topic, None, lambda message: self._take(topic, message), queue_size=_QUEUE, raw=True
        )

    def _take(self, topic: str, message: Any) -> None:
        """A message arrived."""
        raw = RawMessage("", message._buff, "", (0, 0), self._connection(topic, message._connection_header))
        item = (topic, raw, self._node.clock.now())
        size = len(raw.data)
        with self._ready:
            count = self._counts.get(topic, 0)
            if self.error is not None or (self._limit is not None and count >= self._limit):
                return
            if self._waiting + size > self._most:
                self.dropped += 1
                return
            self._counts[topic] = count + 1
            self.messages += 1
            self.bytes += size
            self._waiting += size
            self._queue.append(item)
            self._ready.notify()

    def _connection(self, topic: str, header: dict[str, str]) -> Connection:
        known = self._connections.get((topic, id(header)))
        if known is None:
            definition = header.get("message_definition", "")
            made = Connection(
                0, topic, header.get("type", "*"), header.get("md5sum", "*"), definition, header
            )
            known = self._connections[topic, id(header)] = made, header  # kept: its id must not come back
        return known[0]

    # -- the bag -----------------------------------------------------------------------------

    def _open(self) -> BagWriter:
        path = self._path
        if self._split_bytes is not None or self._split_seconds is not None:
            path = path.with_name(f"{path.stem}_{len(self.paths)}{path.suffix or '.bag'}")
        writer = BagWriter(path, **self._options)
        self.paths.append(path)
        self._first = None
        return writer

    def _write_all(self) -> None:
        try:
            while True:
                with self._ready:
                    while not self._queue and not self._ending.is_set():
                        self._ready.wait(1.0)
                    items, self._queue = self._queue, deque()
                if not items:
                    break
                for item in items:
                    self._write(item)
        except RosError as problem:
            _log.error("! recording stopped: %s", problem)
            self.error = problem
        try:
            self._writer.close()
        except RosError as problem:
            self.error = self.error or problem

    def _write(self, item: Item) -> None:
        topic, raw, stamp = item
        if self._is_full(stamp):
            self._writer.close()
            self._writer = self._open()
            for old_topic, old, _ in self._latched.values():
                self._writer.write(old_topic, old, stamp)
        if self._first is None:
            self._first = stamp
        self._writer.write(topic, raw, stamp)
        if (
            raw.connection.latching
        ):  # each bag of a split recording begins with what a late subscriber would get
            self._latched[topic, raw.connection.callerid] = item
        with self._ready:
            self._waiting -= len(raw.data)

    def _is_full(self, stamp: Time) -> bool:
        if self._first is None:
            return False
        if self._split_bytes is not None and self._writer.size >= self._split_bytes:
            return True
        return (
            self._split_seconds is not None and stamp.to_sec() - self._first.to_sec() >= self._split_seconds
        )


def _compiled(pattern: str | None) -> re.Pattern[str] | None:
    try:
        return None if pattern is None else re.compile(pattern)
    except re.error as problem:
        raise ValueError(f"{pattern!r} is no regular expression: {problem}") from None
