"""Write the bag files of one recording: their names, splitting, and the latched messages repeated in each.

As with rosbag record, the name of a bag ends in `.active` while it is being written. It gets its final name
when it is closed properly, so a file whose name ends in `.bag` is complete.

Source: rosbag recorder.cpp (updateFilenames, checkSize, checkDuration).
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Literal

from rosproto.bag import RawMessage, create_bag
from rosproto.bag.opening import is_mcap_name
from rosproto.errors import BagError
from rosproto.files import replace_file
from rosproto.sentence import say
from rosproto.time import Time

ACTIVE = ".active"
Compression = Literal["none", "bz2", "lz4"]


def bag_name(
    prefix: str = "",
    *,
    dated: bool = True,
    number: int | None = None,
    now: float | None = None,
    ending: str = ".bag",
) -> str:
    """The name that rosbag record would give: `prefix_2026-11-21-09-30-00_0.bag`.

    Args:
        prefix: Path and beginning of the name, with or without the ending.
        dated: Add date and local time.
        number: Number of the split, None without splits.
        now: Seconds since 1970; None is now.
        ending: ".bag", or ".mcap" for MCAP.
    """
    prefix = prefix.removesuffix(ending)
    parts = [prefix] if prefix else []
    if dated:
        parts.append(time.strftime("%Y-%m-%d-%H-%M-%S", time.localtime(now)))
    if number is not None:
        parts.append(str(number))
    if not parts:
        raise ValueError("the bag has no name: give a prefix, or have the date added")
    return "_".join(parts) + ending


class BagSeries:
    """Writes messages into successive bags.

    Args:
        name: Returns the final path of the bag with a given number.
        compression: Compression of the chunks.
        chunk_bytes: Size of a chunk.
        split_bytes: Begin another bag at this size (rosbag record --split --size).
        split_seconds: Begin another bag after this time (--split --duration).
        keep: Delete the oldest bag if there are more than this many (--max-splits).
        repeat_latched: Write the last latched message of every publisher at the start of each bag, so that
            each bag can be played alone.
        overwrite: Replace existing files of the same name.
        on_open: Called with the final path of each bag when it is begun.

    Attributes:
        path: Final path of the current bag.
        paths: Finished bags, in order.
        messages: Messages written, not counting repeated ones.
    """

    def __init__(
        self,
        name: Callable[[int], str],
        *,
        compression: Compression = "none",
        chunk_bytes: int = 768 * 1024,
        split_bytes: int | None = None,
        split_seconds: float | None = None,
        keep: int | None = None,
        repeat_latched: bool = True,
        overwrite: bool = False,
        on_open: Callable[[str], object] | None = None,
    ) -> None:
        self._on_open = on_open
        self._name = name
        self._compression: Compression = compression
        self._chunk_bytes = chunk_bytes
        self._split_bytes = split_bytes
        self._split_ns = None if split_seconds is None else round(split_seconds * 1e9)
        self._keep = keep
        self._splits = split_bytes is not None or split_seconds is not None
        self._repeat = repeat_latched and self._splits
        self._overwrite = overwrite
        self._latched: dict[tuple[str, str], RawMessage] = {}
        self._number = 0
        self._start_ns: int | None = None
        self._finished_bytes = 0
        self.paths: list[str] = []
        self.messages = 0
        self._open()

    @property
    def active_path(self) -> str:
        """Path of the current bag while it is being written."""
        return self.path + ACTIVE

    @property
    def size(self) -> int:
        """Bytes in all bags so far."""
        return self._finished_bytes + (0 if self.path in self.paths else self._writer.size)

    def write(self, topic: str, message: RawMessage, stamp: Time) -> None:
        """Add a message, to a new bag if it is time for one.

        Raises:
            BagError: It cannot be written, or the next bag cannot be opened.
        """
        if self._splits and self._due(stamp):
            self._next(stamp)
        self._writer.write(topic, message, stamp)
        self.messages += 1
        if self._repeat and message.connection.latching:
            self._latched[topic, message.connection.callerid] = message

    def flush(self) -> None:
        """Write the collected messages as a chunk, so that a crash cannot lose them."""
        self._writer.flush()

    def close(self) -> None:
        """Finish the current bag and give it its final name.

        Raises:
            BagError: It cannot be finished; it keeps its `.active` name and can be read up to its last whole
                chunk.
        """
        self._writer.close()
        try:
            replace_file(self.active_path, self.path)
            size = os.path.getsize(self.path)
        except OSError as problem:
            text = "the finished bag cannot be renamed to {path}: {why}"
            text = say(text, path=self.path, why=problem.strerror)
            raise BagError(text, path=self.active_path) from problem
        self._finished_bytes += size
        self.paths.append(self.path)

    def _open(self) -> None:
        path = self._name(self._number)
        if not self._overwrite:
            _check_free(path)
        self._writer = create_bag(
            path + ACTIVE, self._compression, self._chunk_bytes, mcap=is_mcap_name(path)
        )
        self.path = path
        if self._on_open is not None:
            self._on_open(path)

    def _due(self, stamp: Time) -> bool:
        if self._split_bytes is not None and self._writer.size >= self._split_bytes:
            return self._writer.message_count > 0
        if self._split_ns is None:
            return False
        now = stamp.to_nsec()
        if self._start_ns is None or now < self._start_ns:  # time jumped back: count from here
            self._start_ns = now
        passed = (now - self._start_ns) // self._split_ns
        self._start_ns += passed * self._split_ns
        return passed > 0

    def _next(self, stamp: Time) -> None:
        self.close()
        self._number += 1
        self._open()
        for (topic, _), message in self._latched.items():
            self._writer.write(topic, message, stamp)
        while self._keep is not None and len(self.paths) >= self._keep:
            os.remove(self.paths.pop(0))


def _check_free(path: str) -> None:
    if os.path.exists(path):
        raise BagError("already exists; choose another name", path=path)
    if os.path.exists(path + ACTIVE):
        raise BagError(
            "a recording of that name is running or was killed; choose another name, or repair this one with "
            "rosproto bag reindex",
            path=path + ACTIVE,
        )
