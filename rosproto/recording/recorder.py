"""Record a live graph: every message unchanged, with its publisher's definition and header.

Threads: the node's link threads put messages into a `MessageBuffer`, one thread writes them to the files, and
one opens the first, subscribes, with one request to the master for all topics, and asks for new ones. No
Ctrl-C interrupts these threads, so neither an unfinished bag nor a registration half made is left behind. A
slow disk cannot delay receiving: messages that do not fit into the buffer are dropped and counted.
"""

from __future__ import annotations

import errno
import importlib
import os
import re
import shutil
import threading
import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

from rosproto.bag.opening import is_mcap_name
from rosproto.codec import message_class
from rosproto.coercion import as_float
from rosproto.deprecation import former_parameters
from rosproto.errors import BagError, LocalProtocolError, RosError
from rosproto.logs import get_logger
from rosproto.node import Node, Subscriber
from rosproto.recording.buffer import Entry, MessageBuffer, TopicReceiver
from rosproto.recording.files import BagSeries, Compression, bag_name
from rosproto.sentence import both, say
from rosproto.worker_pool import WorkerPool

_log = get_logger("rosproto.recording")

WRITE_EVERY = 0.1  # seconds that a message may wait before it is put into the chunk
LOOK_EVERY = 1.0  # seconds between two checks of the free space on the disk
FLUSH_EVERY = 5.0  # seconds after which even a small chunk is written; a crash can lose that much
CLOSING_THREADS = 32
UNLIMITED_QUEUE = 1 << 30  # the node drops nothing, the buffer decides


@dataclass(frozen=True, slots=True)
class RecorderStats:
    """The state of a recording.

    Attributes:
        messages: Messages written.
        dropped: Messages dropped because the buffer was full.
        bytes: Bytes in the files.
        waiting_bytes: Bytes received and not written yet.
        topics: Number of topics subscribed.
        seconds: Seconds since the start, until it has finished.
        path: The bag being written.
    """

    messages: int
    dropped: int
    bytes: int
    waiting_bytes: int
    topics: int
    seconds: float
    path: str


class Recorder:
    """Records topics of a node's graph until it is closed; use it in a `with` block.

    Messages are stamped with the node's clock: with /use_sim_time, call `node.clock.wait_for_time` before.

    Args:
        node: The node that subscribes; what it publishes itself is recorded, too.
        path: The bag; when split, `name_0.bag`, `name_1.bag` and so on. None: `prefix` with date and time.
        topics: Names to record, with any publishers, now or later.
        pattern: Also every topic whose whole name matches this regular expression, as they appear.
        exclude: But none whose whole name matches this one.
        selection: Instead of these three: several patterns, everything, a node's topics.
        prefix: Path and beginning of the name (rosbag record -o).
        compression: "none", "bz2" or "lz4".
        chunk_bytes: Size of a chunk.
        split_bytes: Begin another bag at this size; names are then numbered from 0.
        split_seconds: Begin another bag after this time.
        keep: With splits, the most bags to keep; older ones are deleted.
        repeat_latched: Repeat latched messages at the start of each split.
        limit: Messages to record of each topic; the recording is finished when every topic has that many.
        max_seconds: Finish after this time.
        max_bytes: Finish at this size.
        buffer_bytes: The most bytes that wait for the disk; beyond it the oldest are dropped and counted.
        poll: Seconds between two requests to the master for new topics.
        overwrite: Replace existing files of the same name.
        tcp_nodelay, unreliable: See `Node.subscriber`.
        announce: Publish the name of each bag, latched, on `begin_write` when it is begun (rosbag record -p).
        min_free_bytes: Close the bag properly and end with an error when the disk has less free space.
        form: "bag" or "mcap" (extra `mcap`); None: MCAP if `path` ends in `.mcap`, else a bag.

    Raises:
        BagError: The file cannot be opened, or exists.
        ValueError: No topics, or an option out of range.
    """

    @former_parameters(most_seconds="max_seconds", most_bytes="max_bytes", least_free_bytes="min_free_bytes")
    def __init__(
        self,
        node: Node,
        path: str | os.PathLike[str] | None = None,
        topics: Iterable[str] = (),
        *,
        pattern: str | None = None,
        exclude: str | None = None,
        selection: TopicSelection | None = None,
        prefix: str = "",
        compression: Compression = "none",
        chunk_bytes: int = 768 * 1024,
        split_bytes: int | None = None,
        split_seconds: float | None = None,
        keep: int | None = None,
        repeat_latched: bool = True,
        limit: int | None = None,
        max_seconds: float | None = None,
        max_bytes: int | None = None,
        buffer_bytes: int = 256 << 20,
        poll: float = 1.0,
        overwrite: bool = False,
        tcp_nodelay: bool = False,
        unreliable: bool = False,
        announce: bool = False,
        min_free_bytes: int = 0,
        form: Literal["bag", "mcap"] | None = None,
    ) -> None:
        self._node = node
        self._selection = selection or TopicSelection(
            [node.resolve_name(topic) for topic in topics],
            patterns=() if pattern is None else [pattern],
            exclude=() if exclude is None else [exclude],
        )
        self._limit = limit
        self._max_seconds = as_float(max_seconds)
        self._max_bytes = max_bytes
        self._poll = as_float(poll)
        self._nodelay = tcp_nodelay
        self._unreliable = unreliable
        self._min_free_bytes = min_free_bytes
        self._announcer = (
            node.publisher("begin_write", message_class("std_msgs/String"), latch=True) if announce else None
        )
        splits = split_bytes is not None or split_seconds is not None
        began = time.time()
        if form is None and path is not None and is_mcap_name(path):
            form = "mcap"
        ending = ".mcap" if form == "mcap" else ".bag"
        self._buffer = MessageBuffer(buffer_bytes, chunk_bytes)
        self._series: BagSeries
        self._open_series = partial(
            BagSeries,
            lambda number: bag_name(
                prefix if path is None else os.fspath(path),
                dated=path is None,
                number=number if splits else None,
                now=began,
                ending=ending,
            ),
            compression=compression,
            chunk_bytes=chunk_bytes,
            split_bytes=split_bytes,
            split_seconds=as_float(split_seconds),
            keep=keep,
            repeat_latched=repeat_latched,
            overwrite=overwrite,
            on_open=self._announce,
        )
        self._subscribers: dict[str, Subscriber] = {}
        self._counts: dict[str, int] = {}
        self._began = time.monotonic()
        self._over: float | None = None
        self._flushed = self._looked = self._began
        self._stopping = threading.Event()
        self._finished = threading.Event()
        self._error: RosError | None = None
        self._raised = False
        self._refusal: BaseException | None = None  # why the bag was not opened, or the topics not subscribed
        self._subscribed = threading.Event()
        self._writer = threading.Thread(target=self._write, name="rosproto:record writer", daemon=True)
        self._finder = threading.Thread(target=self._find, name="rosproto:record topics", daemon=True)
        # The writer needs this for the first chunk; imported then, it would hold up the receiving threads.
        importlib.import_module("numpy")
        try:
            self._finder.start()
            while not self._subscribed.wait(1.0):  # each request of the finder has its own deadline
                pass
            if self._refusal is not None:
                raise self._refusal
        except BaseException:
            self.close()
            raise

    # -- what a program calls -------------------------------------------------------------------------------

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Recorder {self._series.path}: {self.messages} messages, {self.dropped} dropped>"

    @property
    def topics(self) -> list[str]:
        """Topics subscribed so far."""
        return sorted(self._subscribers)

    @property
    def paths(self) -> list[Path]:
        """The bags; last the one being written, whose name ends in `.active` until it is finished."""
        paths = [Path(path) for path in self._series.paths]
        present = Path(self._series.path)
        return paths if present in paths else [*paths, present]

    @property
    def messages(self) -> int:
        """Messages written."""
        return self._series.messages

    @property
    def bytes(self) -> int:
        """Bytes in the files."""
        return self._series.size

    @property
    def dropped(self) -> int:
        """Messages dropped because the buffer was full."""
        return self._buffer.dropped

    @property
    def error(self) -> RosError | None:
        """The error that ended it early (a full disk), None if there is none; `wait` and `close` raise it."""
        return self._error

    @property
    def finished(self) -> bool:
        """True when a limit is reached, writing failed, or it is closed."""
        return self._finished.is_set()

    def stats(self) -> RecorderStats:
        """The current state."""
        return RecorderStats(
            messages=self.messages,
            dropped=self.dropped,
            bytes=self.bytes,
            waiting_bytes=self._buffer.bytes,
            topics=len(self._subscribers),
            seconds=(self._over or time.monotonic()) - self._began,
            path=self._series.path,
        )

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until it finishes by itself; False when it did not in time.

        Raises:
            BagError: Writing failed (the disk is full); the bag is readable up to its last whole chunk.
        """
        finished = self._finished.wait(as_float(timeout))
        self._raise()
        return finished

    def wait_for_topics(self, count: int, timeout: float = 5.0) -> None:
        """Wait until that many topics have a publisher connected.

        Raises:
            TimeoutError: They did not in time.
        """
        end = time.monotonic() + as_float(timeout)
        while sum(s.connections > 0 for s in list(self._subscribers.values())) < count:
            if time.monotonic() > end:
                raise TimeoutError(
                    f"fewer than {count} of {self.topics} have a publisher after {timeout:g} s"
                )
            self._finished.wait(0.01)

    def close(self) -> None:
        """Stop receiving, write everything that waits, finish the bag. May be called again.

        Raises:
            BagError: Writing failed, and the error has not been raised yet.
        """
        self._stopping.set()
        if self._finder.is_alive():
            self._finder.join(10.0)
        # Several at a time: each has a request to the master, and waits for the thread of its link.
        pool = WorkerPool("rosproto:record closing", CLOSING_THREADS, daemon=True)
        for closing in [pool.add(subscriber.close) for subscriber in list(self._subscribers.values())]:
            closing.result()
        pool.close()
        pool.join(1.0)
        self._buffer.close()
        if self._writer.ident is not None:  # else the bag could not be opened
            self._writer.join()  # as long as the disk takes: no received message is discarded
        self._finished.set()
        if self._announcer is not None:
            self._announcer.close()
        self._raise()

    # -- topics ---------------------------------------------------------------------------------------------

    def _find(self) -> None:
        """Thread: open the bag, subscribe to the chosen topics, and to others as they appear. The master may
        be away for a while."""
        try:
            self._series = self._open_series()
            self._writer.start()
            self._subscribe(self._selection.topics)
            if self._selection.is_open:
                self._look()
        except BaseException as refusal:
            self._refusal = refusal
            return
        finally:
            self._subscribed.set()
        if not self._selection.is_open:
            return
        away = False
        while not self._stopping.wait(self._poll):
            try:
                self._look()
                away = False
            except LocalProtocolError:
                return  # the node is closed
            except (RosError, OSError) as problem:
                if not away:
                    _log.warning("! cannot ask for new topics, trying again: %s", problem)
                away = True

    def _look(self) -> None:
        state = self._node.master.get_system_state()
        self._subscribe(
            topic
            for topic in state.publishers
            if topic not in self._subscribers
            and self._selection.takes(topic, state.subscribers.get(topic, ()))
        )

    def _subscribe(self, topics: Iterable[str]) -> None:
        new: dict[str, Subscriber] = {}
        try:
            with self._node.batch():
                for topic in topics:
                    if self._stopping.is_set():
                        break
                    new[topic] = self._subscriber(topic)
        finally:
            # A topic that the master has refused is tried again.
            stand = {topic: subscriber for topic, subscriber in new.items() if not subscriber.closed}
            self._subscribers = {**self._subscribers, **stand}
            for topic in stand:
                _log.info("= recording %s", topic)

    def _subscriber(self, topic: str) -> Subscriber:
        # Inline, and with a queue that is never full: every message goes to the buffer in the thread that
        # received it. Only the buffer may drop messages, and it counts them.
        return self._node.subscriber(
            topic,
            None,
            TopicReceiver(topic, self._node, self._buffer),
            raw=True,
            queue_size=UNLIMITED_QUEUE,
            inline=True,
            tcp_nodelay=self._nodelay,
            unreliable=self._unreliable,
        )

    # -- writing --------------------------------------------------------------------------------------------

    def _write(self) -> None:
        """Thread: write the buffer to the files until it is closed and empty, or a limit or error ends it."""
        try:
            while not self._is_done():
                entries = self._buffer.take(WRITE_EVERY)
                if not entries and self._stopping.is_set():
                    break
                self._put(entries)
        except RosError as problem:
            self._error = problem
        finally:
            self._over = time.monotonic()
            self._buffer.close()
            try:
                self._series.close()
            except RosError as problem:
                self._error = self._error or problem
            else:
                self._name_what_is_left()
            self._finished.set()

    def _name_what_is_left(self) -> None:
        """Use the final name in the error if the bag could still be finished after writing failed."""
        error = self._error
        if isinstance(error, BagError) and error.path == self._series.active_path:
            self._error = BagError(error.reason, path=self._series.path, offset=error.offset)
            self._error.__cause__ = error.__cause__

    def _put(self, entries: list[Entry]) -> None:
        write, limit = self._series.write, self._limit
        for topic, message, stamp in entries:
            if limit is not None:
                count = self._counts.get(topic, 0)
                if count >= limit:
                    continue
                self._counts[topic] = count + 1
            write(topic, message, stamp)
        now = time.monotonic()
        if now - self._flushed > FLUSH_EVERY:
            self._flushed = now
            self._series.flush()
        if self._min_free_bytes and now - self._looked >= LOOK_EVERY:
            self._looked = now
            self._check_room()

    def _check_room(self) -> None:
        folder = os.path.dirname(os.path.abspath(self._series.path))
        free = shutil.disk_usage(folder).free
        if free < self._min_free_bytes:
            template = "{left} MB are left on the disk, less than the {least} that are to stay free"
            left = say(template, left=free >> 20, least=self._min_free_bytes >> 20)
            raise BagError(
                both(left, "the recording has ended, what was received until then is in the bag"),
                path=self._series.path,
            ) from OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))  # as when there is none left

    def _announce(self, path: str) -> None:
        """Publish the name of a bag that was begun."""
        if self._announcer is not None:
            self._announcer.publish(data=path)

    def _is_done(self) -> bool:
        if self._max_seconds is not None and time.monotonic() - self._began >= self._max_seconds:
            return True
        if self._max_bytes is not None and self._series.size >= self._max_bytes:
            return True
        if self._limit is None or not self._subscribers:
            return False
        return all(self._counts.get(topic, 0) >= self._limit for topic in list(self._subscribers))

    def _raise(self) -> None:
        if self._error is not None and not self._raised:
            self._raised = True
            raise self._error


# -- which topics -------------------------------------------------------------------------------------------


class TopicSelection:
    """A choice of topics, made once and applied to every topic that appears.

    Args:
        topics: Global names, chosen whether or not they have publishers yet.
        patterns: Regular expressions for whole names (rosbag record -e).
        exclude: Regular expressions for whole names that `patterns`, `all` and `node` leave out.
        all: Every topic.
        node: Every topic that this node subscribes to.

    Raises:
        ValueError: Nothing is chosen, or a pattern is invalid.
    """

    def __init__(
        self,
        topics: Iterable[str] = (),
        *,
        patterns: Iterable[str] = (),
        exclude: Iterable[str] = (),
        all: bool = False,
        node: str | None = None,
    ) -> None:
        self.topics = tuple(dict.fromkeys(topics))
        self._patterns = [_compiled(pattern) for pattern in patterns]
        self._exclude = [_compiled(pattern) for pattern in exclude]
        self._all = all
        self.node = node
        if not (self.topics or self._patterns or all or node):
            raise ValueError("nothing to record: name topics, or give a pattern, a node, or all")

    @property
    def is_open(self) -> bool:
        """True when topics that appear later may be chosen, so that the master must be asked again."""
        return bool(self._all or self._patterns or self.node)

    def takes(self, topic: str, subscribers: Iterable[str] = ()) -> bool:
        """Whether a topic is chosen; `subscribers` are the nodes that subscribe to it."""
        if topic in self.topics:
            return True
        if any(pattern.fullmatch(topic) for pattern in self._exclude):
            return False
        if self._all or any(pattern.fullmatch(topic) for pattern in self._patterns):
            return True
        return self.node is not None and self.node in subscribers


def _compiled(pattern: str) -> re.Pattern[str]:
    try:
        return re.compile(pattern)
    except re.error as problem:
        raise ValueError(say("{re!r} is not a regular expression: {why}", re=pattern, why=problem)) from None
