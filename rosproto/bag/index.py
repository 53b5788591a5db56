"""What a bag holds and where: from its index section, or from a scan of the whole file when that is missing.

A bag that was closed properly ends with its connections and one chunk info record for each chunk; the file
header says where they start. Reading those is all it takes to open a bag of any size.

A crashed recorder leaves `index_pos` 0, a last chunk that is cut off, and often a chunk header that still
says 0 bytes (recorders fill it in when the chunk is complete). A damaged disk or a broken copy cuts the
file anywhere or changes bytes. Then the records are followed one after the other; the index records after
each chunk save reading its data. After damage, the scan goes on at the next chunk record it finds. All that
was wrong is listed, never guessed silently.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from struct import Struct
from typing import TYPE_CHECKING

from rosproto.bag.bag_file import Source
from rosproto.bag.chunk import ChunkData, RecordHead, read_chunk, read_head
from rosproto.bag.compression import COMPRESSIONS
from rosproto.bag.limits import MOST_CONNECTIONS
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
    FileHeader,
    connection_from_fields,
    decode_fields,
    decode_text_fields,
    index_header,
    op_of,
)
from rosproto.bag.rows import Rows
from rosproto.errors import BagError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["BagIndex", "open_index", "scan"]

_U32 = Struct("<I")
_WINDOW = 1 << 20
_NO_BAGS = {
    b"\x89MCAP0": "this is MCAP",
    b"SQLite format 3": "this is a bag of ROS 2",
    b"version https://git-lfs": "this stands in for the file until `git lfs pull`",
    b"PK\x03\x04": "this is a ZIP archive, unpack it first",
    b"\x1f\x8b": "this is packed with gzip, unpack it first",
    b"BZh": "this is packed with bzip2, unpack it first",
    b"\x28\xb5\x2f\xfd": "this is packed with zstd, unpack it first",
}
"""What people take for a bag, by its first bytes."""


@dataclass(slots=True)
class BagIndex:
    """Table of contents.

    Attributes:
        connections: By id.
        chunks: In file order.
        end: Position after the last record that belongs to the chunks (the index section starts there, or
        nothing). damage: What was wrong, in words with positions; empty for a sound bag.
        closed: True when the bag's own index was used.
        resumed: True when a scan met damage and went on behind it, or had to leave messages out.
        version: Of the format, "2.0" as a rule; nothing else is known to differ in another 2.x.
        head: Position of the file header, behind the version line.
    """

    connections: dict[int, Connection] = field(default_factory=dict)
    chunks: list[ChunkInfo] = field(default_factory=list)
    end: int = 0
    damage: list[str] = field(default_factory=list)
    closed: bool = False
    resumed: bool = False
    version: str = "2.0"
    head: int = len(MAGIC)

    def spans(self) -> dict[int, int]:
        """Bytes from each chunk's position to the next chunk (or the end of the chunks)."""
        positions = sorted(chunk.pos for chunk in self.chunks)
        return {a: b - a for a, b in zip(positions, [*positions[1:], self.end], strict=False)}


def open_index(source: Source) -> BagIndex:
    """Find out what a bag holds, by its index or by a scan.

    Args:
        source: The file.

    Raises:
        BagError: It is no bag, or one of version 1, or encrypted.
    """
    version, start = _read_version(source)
    found = _open_behind(source, start)
    found.version, found.head = version, start
    return found


def _open_behind(source: Source, start: int) -> BagIndex:
    """`open_index` behind the version line."""
    try:
        head = read_head(source, start)
        header = FileHeader.from_fields(head.fields)
    except BagError as problem:
        return _without_file_header(source, start, problem)
    if head.op != OP_FILE_HEADER:
        return _without_file_header(
            source, start, source.error(f"op {head.op} instead of a file header", start)
        )
    if header.encryptor:
        raise source.error(
            f"the bag is encrypted with {header.encryptor}; decrypt it where the key is: rosbag decompress"
        )
    first = head.data_pos + head.data_size
    if first >= source.size:
        return _nothing_follows(source, header, first)
    if header.index_pos == 0:
        found = scan(source, first)
        found.damage.insert(0, "the bag was never closed: no index; its records were scanned")
        return found
    try:
        return _read_index_section(source, header, first)
    except BagError as problem:
        found = scan(source, first)
        found.damage.insert(0, f"the index is not usable, the records were scanned: {problem}")
        return found


def _nothing_follows(source: Source, header: FileHeader, first: int) -> BagIndex:
    """A file that is at most a file header: an empty bag, or the very beginning of another one."""
    found = BagIndex(end=min(first, source.size), closed=first == header.index_pos == source.size)
    if first > source.size:
        found.damage.append(f"the file ends inside its file header, at byte {source.size}")
        found.resumed = True
    elif header.index_pos == 0:
        found.damage.append("the bag was never closed, and holds no messages")
    elif not found.closed:
        found.damage.append(f"the file ends after its header, its index should be at byte {header.index_pos}")
    return found


def _without_file_header(source: Source, start: int, problem: BagError) -> BagIndex:
    found = scan(source, start)
    found.resumed = True
    found.damage.insert(0, f"the file header is damaged: {problem}")
    return found


def _read_version(source: Source) -> tuple[str, int]:
    """Version of the format, and where the first record begins; any 2.x is read, as rosbag does."""
    line = source.read_at(0, 64)
    if line.startswith(MAGIC):
        return "2.0", len(MAGIC)
    if not line:
        raise source.error("the file is empty")
    version = re.match(rb"#ROS\w* V(\d+\.\d+)[^\n]*\n?", line)
    if version is None:
        if MAGIC.startswith(line):
            raise source.error(f"the file ends after {len(line)} bytes, inside the version line")
        other = next((f"; {what}" for start, what in _NO_BAGS.items() if line.startswith(start)), "")
        raise source.error(f"not a bag: it starts with {line[:16]!r}, expected {MAGIC[:-1]!r}{other}")
    number = version.group(1).decode()
    if number.startswith("2."):
        return number, version.end()
    raise source.error(
        f"bag version {number} ({line.splitlines()[0].decode('latin-1')!r}); only 2.x is read"
        + (". Convert it where ROS is installed: rosbag fix" if number < "2.0" else "")
    )


def _read_index_section(source: Source, header: FileHeader, first: int) -> BagIndex:
    """Connections and chunk infos at the end of the file; BagError when they do not add up."""
    pos = header.index_pos
    if not first <= pos <= source.size:
        raise source.error(f"index_pos {pos} is outside the file of {source.size} bytes")
    found = BagIndex(end=pos, closed=True)
    section = source.read_at(pos, source.size - pos)
    at = 0
    while at < len(section):
        try:
            at = _index_record(section, at, found)
        except BagError as problem:
            raise source.error(str(problem), pos + at) from None
    if (len(found.connections), len(found.chunks)) != (header.connection_count, header.chunk_count):
        raise source.error(
            f"the index has {len(found.connections)} connections and {len(found.chunks)} chunks, "
            f"the file header says {header.connection_count} and {header.chunk_count}"
        )
    found.chunks.sort(key=lambda chunk: chunk.pos)
    positions = [chunk.pos for chunk in found.chunks]
    if positions and not first <= positions[0] <= positions[-1] < pos:
        raise source.error("the index names chunks outside the file's chunks")
    if len(set(positions)) != len(positions) or not _all_known(found):
        raise source.error("the index names a chunk twice, or messages of a connection that is not listed")
    return found


def _index_record(section: bytes, at: int, found: BagIndex) -> int:
    """Take one record of the index section; returns where the next one is."""
    if at + 8 > len(section):
        raise BagError("the index section is cut off")
    header_end: int = at + 4 + _U32.unpack_from(section, at)[0]
    if header_end + 4 > len(section):
        raise BagError("the index section is cut off")
    fields = decode_fields(section, at + 4, header_end)
    end: int = header_end + 4 + _U32.unpack_from(section, header_end)[0]
    if end > len(section):
        raise BagError("the index section is cut off")
    op = op_of(fields)
    if op == OP_CONNECTION:
        connection = connection_from_fields(fields, decode_text_fields(section, header_end + 4, end))
        found.connections[connection.id] = connection
        if len(found.connections) > MOST_CONNECTIONS:
            raise BagError(f"more than {MOST_CONNECTIONS} connections")
    elif op == OP_CHUNK_INFO:
        found.chunks.append(ChunkInfo.from_record(fields, section[header_end + 4 : end]))
    else:
        raise BagError(f"a record with op {op} in the index section")
    return end


def _all_known(found: BagIndex) -> bool:
    return all(chunk.counts.keys() <= found.connections.keys() for chunk in found.chunks)


def scan(source: Source, first: int) -> BagIndex:
    """Follow the records from `first` to the end of the file, whatever the index says."""
    return _Scan(source).run(first)


class _Scan:
    """One pass over a file's records."""

    def __init__(self, source: Source) -> None:
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
        """A chunk and the index records after it; returns the position of what comes next."""
        after = head.data_pos + head.data_size
        if ChunkHeader.from_fields(head.fields).compression not in COMPRESSIONS:
            raise self._source.error(f"a chunk with compression {head.fields.get('compression')!r}", at)
        if head.data_size == 0 and self._is_empty(after):
            return after
        if head.data_size == 0 or after > self._source.size:
            self._found.damage.append(f"the chunk at byte {at} is cut off; what is whole in it is kept")
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
        """Whether a chunk that claims 0 bytes has none: data of a chunk never begins with these records."""
        try:
            return read_head(self._source, after).op in (OP_CHUNK, OP_INDEX, OP_CHUNK_INFO)
        except BagError:
            return False

    def _indexes(self, info: ChunkInfo, at: int) -> tuple[int, bool]:
        """Read the index records at `at` into `info`.

        Returns:
            Where they end, and whether another sound record follows: then they are complete.
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
        """Read a chunk for its connections, and, unless its index told, for counts and times."""
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
            data.rows(())
        except BagError as problem:
            self._found.damage.append(f"the chunk at byte {info.pos} is damaged: {problem}")
            info.partial, info.indexed = True, False
        else:
            return data
        try:
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
            if len(known) < MOST_CONNECTIONS:
                known.setdefault(connection.id, connection)
            elif connection.id not in known:
                note = (
                    f"more than {MOST_CONNECTIONS} connections; the others, and their messages, are left out"
                )
                if note not in self._found.damage:
                    self._found.damage.append(note)

    def _drop_unknown(self) -> None:
        """Messages whose connection record was lost have no topic and no type: they cannot be given."""
        for chunk in self._found.chunks:
            for unknown in chunk.counts.keys() - self._found.connections.keys():
                count = chunk.counts.pop(unknown)
                chunk.indexed = False  # its index records count more than is kept
                self._found.resumed = True
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
                        self._found.resumed = True
                        return start
            at += max(len(window) - 64, 1)  # a record head may straddle two windows
        return self._source.size

    def _is_chunk(self, at: int) -> bool:
        try:
            head = read_head(self._source, at)
            return head.op == OP_CHUNK and ChunkHeader.from_fields(head.fields).compression in COMPRESSIONS
        except BagError:
            return False


def _chunk_starts(op_at: int) -> list[int]:
    """Where a chunk record may start whose op field is at `op_at`: op comes first or second."""
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


def _counted(rows: Rows) -> dict[int, int]:
    import numpy as np

    ids, counts = np.unique(rows.conn, return_counts=True)
    return dict(zip(ids.tolist(), counts.tolist(), strict=True))
