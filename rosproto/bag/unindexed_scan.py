"""Scan a bag that has no usable index section: follow all its records and build a `BagIndex` in memory.

A crashed recorder leaves `index_pos` 0, a last chunk that is cut off, and often a chunk header with 0 bytes
as size (recorders fill it in when the chunk is complete). A bad disk or an interrupted copy truncates
the file anywhere or changes bytes. The data of a chunk is only read if its index records are missing. After
damage, the scan continues at the next chunk record. `BagIndex.damage` lists all damage. The file is not
changed.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rosproto.bag.bag_file import MAX_CONNECTIONS, BagFile
from rosproto.bag.chunk import ChunkData, RecordHead, read_chunk, read_head
from rosproto.bag.compression import COMPRESSIONS
from rosproto.bag.message_offsets import MessageTable
from rosproto.bag.records import (
    MAGIC,
    NS,
    OP_CHUNK,
    OP_CHUNK_INFO,
    OP_CONNECTION,
    OP_FILE_HEADER,
    OP_INDEX,
    ChunkHeader,
    ChunkInfo,
    Connection,
    connection_from_fields,
    decode_text_fields,
    index_header,
)
from rosproto.errors import BagError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


# -- contents -----------------------------------------------------------------------------------------------


@dataclass(slots=True)
class BagIndex:
    """Table of contents.

    Attributes:
        connections: By id.
        chunks: In file order.
        end: Position behind the last record of the chunks, where the index section begins if there is one.
        damage: Descriptions of the damage with positions; empty for a sound bag.
        closed: True when the bag's own index was used.
        resumed: True when a scan met damage and continued after it, or omitted messages.
        lost: True when messages before the end of the file are missing, as far as a scan can tell.
        trailing_bytes: Bytes behind the index, which do not belong to the bag.
        version: Of the format, usually "2.0"; other 2.x versions are read in the same way.
        head: Position of the file header, behind the version line.
    """

    connections: dict[int, Connection] = field(default_factory=dict)
    chunks: list[ChunkInfo] = field(default_factory=list)
    end: int = 0
    damage: list[str] = field(default_factory=list)
    closed: bool = False
    resumed: bool = False
    lost: bool = False
    trailing_bytes: int = 0
    version: str = "2.0"
    head: int = len(MAGIC)

    def spans(self) -> dict[int, int]:
        """Bytes from each chunk's position to the next chunk (or the end of the chunks)."""
        positions = sorted(chunk.pos for chunk in self.chunks)
        return {a: b - a for a, b in zip(positions, [*positions[1:], self.end], strict=False)}


_WINDOW = 1 << 20


def scan(source: BagFile, first: int) -> BagIndex:
    """Follow the records from `first` to the end of the file, without the index."""
    return _Scan(source).run(first)


class _Scan:
    """One pass over a file's records."""

    def __init__(self, source: BagFile) -> None:
        self._source = source
        self._found = BagIndex()

    def run(self, first: int) -> BagIndex:
        found, at = self._found, first
        found.end = first
        while at < self._source.size:
            try:
                at = self._record(at)
            except BagError as problem:
                found.damage.append(str(problem))
                at = self._next_chunk(at + 1)
            self._source.scanned(at)
        self._drop_unknown()
        return found

    def _record(self, at: int) -> int:
        head = read_head(self._source, at)
        after = head.data_pos + head.data_size
        if head.op == OP_CHUNK:
            return self._chunk(at, head)
        if head.op == OP_CONNECTION:
            if after > self._source.size:
                raise self._source.error("the file ends inside a connection record", at)
            data = self._source.read_at(head.data_pos, head.data_size)
            self._learn([connection_from_fields(head.fields, decode_text_fields(data, 0, len(data)))])
        elif head.op not in (OP_CHUNK_INFO, OP_INDEX, OP_FILE_HEADER):
            raise self._source.error(f"a record with op {head.op} between the chunks", at)
        if after > self._source.size:
            raise self._source.error("the file ends inside a record", at)
        return after

    def _chunk(self, at: int, head: RecordHead) -> int:
        """A chunk and the index records after it; returns the position after them."""
        after = head.data_pos + head.data_size
        if ChunkHeader.from_fields(head.fields).compression not in COMPRESSIONS:
            raise self._source.error(f"a chunk with compression {head.fields.get('compression')!r}", at)
        if head.data_size == 0 and self._is_empty(after):
            return after
        if head.data_size == 0 or after > self._source.size:
            self._found.damage.append(f"the chunk at byte {at} is truncated; its complete records are kept")
            self._open_chunk(ChunkInfo(at, 0, 0, indexed=False, partial=True))
            return self._source.size
        info = ChunkInfo(at, 0, 0)
        after, trusted = self._indexes(info, after)
        if trusted and info.counts.keys() <= self._found.connections.keys():
            self._keep(info, after)
            return after
        info.indexed = trusted
        self._open_chunk(info)
        self._found.end = max(self._found.end, after)
        return after

    def _is_empty(self, after: int) -> bool:
        """Whether a chunk that claims 0 bytes is empty: a chunk's data never begins with these records."""
        try:
            return read_head(self._source, after).op in (OP_CHUNK, OP_INDEX, OP_CHUNK_INFO)
        except BagError:
            return False

    def _indexes(self, info: ChunkInfo, at: int) -> tuple[int, bool]:
        """Read the index records at `at` into `info`.

        Returns:
            Where they end, and whether a sound record follows, which proves that they are complete.
        """
        times: list[NDArray[np.int64]] = []
        while at < self._source.size:
            try:
                head = read_head(self._source, at)
            except BagError:
                return at, False
            if head.op != OP_INDEX:
                _span(info, times)
                return at, head.op in (OP_CHUNK, OP_CONNECTION, OP_CHUNK_INFO) and bool(times)
            if head.data_pos + head.data_size > self._source.size:
                return at, False
            conn, count = index_header(head.fields)
            if count:
                times.append(_index_times(self._source.read_at(head.data_pos, head.data_size)))
                info.counts[conn] = info.counts.get(conn, 0) + count
            at = head.data_pos + head.data_size
        return at, False

    def _open_chunk(self, info: ChunkInfo) -> None:
        """Read a chunk's connections and, if index records are missing, its counts and times."""
        data = self._load(info)
        if data is None:
            return
        self._learn(data.connections())
        if not info.indexed:
            rows = data.rows()
            info.counts = _counted(rows)
            _span(info, [rows.time] if len(rows.conn) else [])
        self._keep(info, info.pos)

    def _load(self, info: ChunkInfo) -> ChunkData | None:
        try:
            data = read_chunk(self._source, info, 0, with_index=False)
            data.rows(())  # raises if a record is damaged
        except BagError as problem:
            self._found.damage.append(f"the chunk at byte {info.pos} is damaged: {problem}")
            self._found.lost = True
            info.partial, info.indexed = True, False
        else:
            return data
        try:  # again, as a partial chunk: what stands before the damage
            data = read_chunk(self._source, info, 0, with_index=False)
            data.complete = False
        except BagError:
            return None
        return data

    def _keep(self, info: ChunkInfo, end: int) -> None:
        if info.counts:
            self._found.chunks.append(info)
        self._found.end = max(self._found.end, end)

    def _learn(self, connections: list[Connection]) -> None:
        known = self._found.connections
        for connection in connections:
            if len(known) < MAX_CONNECTIONS:
                known.setdefault(connection.id, connection)
            elif connection.id not in known:
                note = (
                    f"more than {MAX_CONNECTIONS} connections; the others, and their messages, are left out"
                )
                if note not in self._found.damage:
                    self._found.damage.append(note)

    def _drop_unknown(self) -> None:
        """Drop messages whose connection record was lost: they have neither topic nor type."""
        for chunk in self._found.chunks:
            for unknown in chunk.counts.keys() - self._found.connections.keys():
                count = chunk.counts.pop(unknown)
                chunk.indexed = False  # its index records include dropped messages
                self._found.resumed = self._found.lost = True
                self._found.damage.append(
                    f"{count} messages in the chunk at byte {chunk.pos} belong to connection {unknown}, "
                    "whose record is lost"
                )

    def _next_chunk(self, at: int) -> int:
        """Position of the first chunk record at or after `at`; the end of the file when there is none."""
        while at < self._source.size:
            window = self._source.read_at(at, _WINDOW)
            for match in re.finditer(rb"op=\x05", window):
                for start in _chunk_starts(at + match.start()):
                    if start >= at and self._is_chunk(start):
                        self._found.damage.append(f"the scan goes on at the chunk at byte {start}")
                        self._found.resumed = self._found.lost = True
                        return start
            at += max(len(window) - 64, 1)  # a record head may straddle two windows
            self._source.scanned(at)
        return self._source.size

    def _is_chunk(self, at: int) -> bool:
        try:
            head = read_head(self._source, at)
            return head.op == OP_CHUNK and ChunkHeader.from_fields(head.fields).compression in COMPRESSIONS
        except BagError:
            return False


def _chunk_starts(op_at: int) -> list[int]:
    """Possible starts of a chunk record with its op field at `op_at`: op is its first or second field."""
    first = op_at - 8
    return [first, *[first - 4 - len("compression=") - len(name) for name in COMPRESSIONS]]


def _index_times(entries: bytes) -> NDArray[np.int64]:
    import numpy as np

    table = np.frombuffer(entries, "<u4").reshape(-1, 3)
    times: NDArray[np.int64] = table[:, 0].astype(np.int64) * NS + table[:, 1]
    return times


def _span(info: ChunkInfo, times: list[NDArray[np.int64]]) -> None:
    if times:
        info.start = min(int(t.min()) for t in times)
        info.end = max(int(t.max()) for t in times)


def _counted(rows: MessageTable) -> dict[int, int]:
    import numpy as np

    ids, counts = np.unique(rows.conn, return_counts=True)
    return dict(zip(ids.tolist(), counts.tolist(), strict=True))
