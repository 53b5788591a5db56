"""Split recordings into pieces for parallel reading with Ray, Dask or a process pool.

A piece is one topic in a few adjacent chunks of one file. It contains the index of those chunks, so a worker
reads only them. Every message is in exactly one piece.
"""

from __future__ import annotations

import glob
import logging
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

from rosproto.bag.bag_file import BagLimits
from rosproto.bag.mcap.reader import McapReader
from rosproto.bag.opening import open_bag
from rosproto.bag.reader import BagReader
from rosproto.bag.records import ChunkInfo, Connection
from rosproto.bag.remote import is_remote, remote_files
from rosproto.bag.unindexed_scan import BagIndex
from rosproto.errors import BagError

if TYPE_CHECKING:
    from pyarrow import RecordBatch, Schema, Table

Damaged = Literal["raise", "skip"]
Files = str | os.PathLike[str] | Iterable[str | os.PathLike[str]]
PARTITION_BYTES = 64 << 20
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Partition:
    """A piece of a topic. It can be pickled, and read any number of times in any process.

    Attributes:
        file: Path or URL of the recording.
        topic: The topic.
        message_count: Messages in it.
        size: Bytes of its chunks in the file, of all topics.
        fields: See `batches`.
        damaged: "raise", or "skip" to leave out damaged chunks.
    """

    file: str
    topic: str
    message_count: int
    size: int
    fields: tuple[str, ...] | None
    damaged: Damaged
    connections: tuple[Connection, ...] = field(repr=False)
    chunks: tuple[ChunkInfo, ...] = field(repr=False)
    spans: tuple[int, ...] = field(repr=False)
    loose: tuple[int, ...] | None = field(repr=False, default=None)

    def batches(self) -> Iterator[RecordBatch]:
        """Its messages as pyarrow.RecordBatch, bounded in size; see `BagReader.to_arrow`.

        Raises:
            BagError: The file cannot be read, or this part is damaged; names the file and the byte.
        """
        with self.open() as bag:
            yield from bag.to_arrow(self.topic, self.fields)

    def schema(self) -> Schema:
        """The batches' pyarrow.Schema; reads nothing."""
        from rosproto.bag.arrow import schema_of
        from rosproto.bag.messages import message_class_of

        first = self.connections[0]
        return schema_of(message_class_of(first), first, self.fields)

    def table(self) -> Table:
        """All its batches as one pyarrow.Table."""
        from rosproto.bag.arrow.schema import pyarrow

        return pyarrow().Table.from_batches(list(self.batches()), self.schema())

    def open(self) -> BagReader:
        """A reader of this piece only; use it in a `with` block."""
        return _McapPartitionReader(self) if self.loose is not None else _PartitionReader(self)


def partitions(
    files: Files,
    topics: str | Iterable[str] | None = None,
    *,
    size: int = PARTITION_BYTES,
    fields: Iterable[str] | None = None,
    damaged: Damaged = "raise",
    limits: BagLimits | None = None,
) -> list[Partition]:
    """Split recordings into pieces by their indexes, without reading messages.

    Args:
        files: Bags and MCAP files, folders of them, patterns such as "runs/*.bag", and URLs of all three that
            fsspec supports (extra `remote`); one or several.
        topics: Only these; None for all. Each piece has one topic.
        size: Bytes in the file at which a piece is complete; a chunk is never split.
        fields: Fields to read; see `BagReader.to_arrow`.
        damaged: "raise" at a damaged chunk, or "skip" it. With "skip", a file from a folder or pattern
            that is not a recording is left out with a warning in the log.
        limits: Limits for reading each file.

    Raises:
        BagError: A file cannot be opened or is not a recording; nothing is named or matches; none has these
            topics; a scan, in place of a missing index, found that messages are missing (not with
            `damaged="skip"`).
        ValueError: `size` or `damaged` is out of range.
    """
    if size < 1:
        raise ValueError(f"size {size}: must be at least 1 byte")
    if damaged not in ("raise", "skip"):
        raise ValueError(f'damaged={damaged!r}: "raise" or "skip"')
    chosen = None if fields is None else tuple(fields)
    wanted = None if topics is None else {topics} if isinstance(topics, str) else set(topics)
    found: list[Partition] = []
    seen: set[str] = set()
    for path, named in _paths(files):
        try:
            bag = open_bag(path, limits=limits)
        except BagError as problem:
            # Only files from folders and patterns are left out, not named ones. A file that cannot be opened
            # or reached (the error then has a cause) is not damaged.
            if named or damaged == "raise" or problem.__cause__ is not None:
                raise
            _log.warning("left out: %s", problem)
            continue
        with bag:
            if bag._lost and damaged == "raise":
                raise BagError(
                    f'messages are missing ({"; ".join(bag.damage)}); damaged="skip" takes the others',
                    path=path,
                )
            seen |= set(bag.topics)
            for topic in bag.topics:
                if wanted is None or topic in wanted:
                    found += _pieces(path, bag, topic, size, chosen, damaged)
    if wanted is not None and not wanted <= seen:
        missing = ", ".join(sorted(wanted - seen))
        raise BagError(f"no messages on {missing}; there are {', '.join(sorted(seen)) or 'none at all'}")
    return found


def _pieces(
    path: str, bag: BagReader, topic: str, size: int, fields: tuple[str, ...] | None, damaged: Damaged
) -> Iterator[Partition]:
    connections = tuple(replace(c, header=dict(c.header)) for c in bag.topics[topic].connections)
    numbers = {connection.id for connection in connections}
    loose = tuple(bag._loose) if isinstance(bag, McapReader) else None
    group: list[ChunkInfo] = []
    spans: list[int] = []
    span_of = bag._spans or BagIndex(chunks=[*bag.chunks], end=bag.size).spans()

    def piece() -> Partition:
        count = sum(c.counts.get(number, 0) for c in group for number in numbers)
        return Partition(
            path,
            topic,
            count,
            sum(spans),
            fields,
            damaged,
            connections,
            tuple(group),
            tuple(spans),
            loose,
        )

    for chunk in bag.chunks:
        if numbers.isdisjoint(number for number, count in chunk.counts.items() if count):
            continue
        group.append(chunk)
        spans.append(span_of[chunk.pos])
        if sum(spans) >= size:
            yield piece()
            group, spans = [], []
    if group:
        yield piece()


# -- files -------------------------------------------------------------------------------------------------


def _paths(files: Files) -> list[tuple[str, bool]]:
    """Each file once, and whether it was named explicitly."""
    several = [files] if isinstance(files, (str, os.PathLike)) else list(files)
    found: dict[str, bool] = {}
    for each in several:
        path = os.fspath(each)
        matching = remote_files(path) if is_remote(path) else _local(os.path.expanduser(path))
        if not matching:
            why = "no file matches" if glob.has_magic(path) else "no file in there ends in .bag or .mcap"
            raise BagError(why, path=path)
        for one in matching:
            found[one] = found.get(one, False) or matching == [path]
    if not found:
        raise BagError("no files were named, so there is nothing to split")
    return list(found.items())


def _local(path: str) -> list[str]:
    if os.path.isdir(path):
        return sorted(
            os.path.join(folder, name)
            for folder, _, names in os.walk(path)
            for name in names
            if name.lower().endswith((".bag", ".mcap"))
        )
    if os.path.exists(path) or not glob.has_magic(path):
        return [path]
    return sorted(glob.glob(path, recursive=True))


class _PartitionReader(BagReader):
    """A reader that receives the index as an argument."""

    def __init__(self, piece: Partition) -> None:
        self._piece = piece
        super().__init__(piece.file, skip_damaged=piece.damaged == "skip")

    def _open(self) -> None:
        piece = self._piece
        self._spans = dict(zip([chunk.pos for chunk in piece.chunks], piece.spans, strict=True))
        self._take_contents({c.id: c for c in piece.connections}, list(piece.chunks), [])
        self.message_count = piece.message_count
        self._lost, self.version, self.indexed = False, "", True


class _McapPartitionReader(_PartitionReader, McapReader):
    """A reader of a piece of an MCAP file."""

    def _open(self) -> None:
        super()._open()
        self._loose = set(self._piece.loose or ())
        self._packed = {}  # not needed to read a piece
