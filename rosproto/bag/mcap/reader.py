"""Read MCAP files with the interface of `BagReader`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from rosproto.bag.bag_file import MAX_CONNECTIONS, BagFile
from rosproto.bag.chunk import ChunkData
from rosproto.bag.mcap.chunks import LOOSE, BoundedStream, library, messages_of, misfits, read_mcap_chunk
from rosproto.bag.reader import BagReader
from rosproto.bag.records import ChunkInfo, Connection
from rosproto.errors import BagError, DefinitionError

if TYPE_CHECKING:
    import numpy as np
    from mcap.records import Channel, McapRecord, Schema
    from mcap.records import Message as McapMessage
    from numpy.typing import NDArray


class McapReader(BagReader):
    """An MCAP file with messages of ROS 1 (profile `ros1`), with the interface of `BagReader`.

    Channels are connections; a channel's metadata are its connection header. A file whose recorder died has
    no summary: it is scanned, `damage` lists that, and every complete message can be read.

    Args:
        file: Path, URL (extra `remote`), or a seekable binary file.
        skip_damaged: As for `BagReader`.
        limits: As for `BagReader`.
        scanning: As for `BagReader`.

    Raises:
        BagError: It cannot be opened, is not an MCAP file, or the package mcap is missing (extra `mcap`).
    """

    def _open(self) -> None:
        if self._source.read_at(0, len(MCAP_MAGIC)) != MCAP_MAGIC:
            raise self._source.error("this is not an MCAP file")
        found = read_contents(self._source)
        self._loose = found.loose
        self._packed = found.packed
        self._spans = {}
        self._take_contents(found.connections, found.chunks, found.damage)
        self._lost = found.lost
        self.version = "MCAP 0"
        self.indexed = found.finished

    def _index_times(self, info: ChunkInfo, wanted: Collection[int]) -> NDArray[np.int64] | None:
        return None  # from the messages themselves

    def index_damage(self) -> list[str]:
        return []  # an MCAP file is read without its index records

    def _compression_of(self, info: ChunkInfo) -> tuple[str, int, int]:
        # Messages outside of chunks have no such sizes.
        name, stored, plain = self._packed.get(info.pos, ("", 0, 0))
        return name or "none", stored, plain

    def _read_chunk(self, info: ChunkInfo, max_bytes: int | None = None) -> ChunkData:
        return read_mcap_chunk(self._source, info, info.pos in self._loose)


# -- contents of a file -------------------------------------------------------------------------------------


MCAP_MAGIC = b"\x89MCAP0\r\n"
"""The first bytes of every file, and the last of one that was finished."""


@dataclass(slots=True)
class Contents:
    """The contents of one file.

    Attributes:
        connections: By the channel's number.
        chunks: In file order; `pos` is where the chunk's record begins.
        damage: Descriptions of the damage.
        finished: True when the file was closed properly; then it nearly always has a summary.
        lost: True when a scan omitted messages.
        loose: Positions at which messages outside of chunks begin.
        packed: By position of the chunk: compression, bytes in the file, uncompressed bytes.
    """

    connections: dict[int, Connection] = field(default_factory=dict)
    chunks: list[ChunkInfo] = field(default_factory=list)
    damage: list[str] = field(default_factory=list)
    finished: bool = False
    loose: set[int] = field(default_factory=set)
    lost: bool = False
    packed: dict[int, tuple[str, int, int]] = field(default_factory=dict)


def read_contents(source: BagFile) -> Contents:
    """The contents of a finished or damaged file.

    Raises:
        BagError: The file does not begin with MCAP's magic, or the package mcap is missing.
    """
    wrong = misfits()
    why = ""
    ended = source.read_at(source.size - len(MCAP_MAGIC), len(MCAP_MAGIC)) == MCAP_MAGIC
    try:
        if ended and (found := _by_summary(source)) is not None:
            return found
    except wrong as problem:
        why = str(problem) or type(problem).__name__
    except BagError as problem:
        why = problem.reason
    scan = _Scan(source)
    found = scan.run()
    if scan.whole and not why:  # a writer may omit the summary
        found.finished = True
        return found
    why = why or "it has none, or it does not tell of all messages"
    found.damage.insert(
        0,
        f"the file was not finished, or its summary cannot be used ({why}); it was scanned"
        if ended
        else "the file was not finished: its end is missing; it was scanned",
    )
    return found


def _by_summary(source: BagFile) -> Contents | None:
    """The contents from the summary; None if it does not cover all messages."""
    reader = library("reader").SeekingReader(BoundedStream(source), record_size_limit=_limit(source))
    summary = reader.get_summary()
    if summary is None or summary.statistics is None:
        return None
    indexes = summary.chunk_indexes
    if any(not index.message_index_offsets for index in indexes) or len(indexes) > source.size:
        return None
    found = Contents(finished=True)
    for channel in summary.channels.values():
        found.connections[channel.id] = connection_of(channel, summary.schemas.get(channel.schema_id))
    for index in sorted(indexes, key=lambda i: i.chunk_start_offset):
        counts = {
            channel: _index_count(source, offset) for channel, offset in index.message_index_offsets.items()
        }
        found.chunks.append(
            ChunkInfo(index.chunk_start_offset, index.message_start_time, index.message_end_time, counts)
        )
        found.packed[index.chunk_start_offset] = (
            index.compression,
            index.compressed_size,
            index.uncompressed_size,
        )
        source.scanned(index.chunk_start_offset)
    total = sum(sum(chunk.counts.values()) for chunk in found.chunks)
    if total != summary.statistics.message_count:
        return None  # messages outside of chunks, or a wrong index
    if any(not chunk.counts.keys() <= found.connections.keys() for chunk in found.chunks):
        return None
    return found


def _index_count(source: BagFile, offset: int) -> int:
    """Number of messages in the index record at this offset."""
    records = library("stream_reader").StreamReader(
        BoundedStream(source, offset), skip_magic=True, record_size_limit=_limit(source)
    )
    record = next(records.records)
    if type(record).__name__ != "MessageIndex":
        raise BagError(f"expected an index of messages at byte {offset}")
    return len(record.records)


def _limit(source: BagFile) -> int:
    return min(source.size, source.limits.chunk_bytes + (1 << 20))


class _Scan:
    """One pass over a file's records."""

    def __init__(self, source: BagFile) -> None:
        self._source = source
        self._found = Contents()
        self._schemas: dict[int, Schema] = {}
        self._stated: int | None = None
        self._footer = False

    @property
    def whole(self) -> bool:
        """Whether the file is finished and has the stated number of messages, if any."""
        count = sum(sum(chunk.counts.values()) for chunk in self._found.chunks)
        return self._footer and not self._found.damage and self._stated in (None, count)

    def run(self) -> Contents:
        source, found = self._source, self._found
        stream = BoundedStream(source)
        reader = library("stream_reader").StreamReader(
            stream, emit_chunks=True, record_size_limit=_limit(source)
        )
        at = 8  # behind the magic
        try:
            for record in reader.records:
                self._take(record, at)
                at = stream.tell()
                source.scanned(at)
        except misfits() as problem:
            if at == 8 and not self._schemas and not found.chunks and source.size < 8:
                raise source.error("this is not an MCAP file") from problem
            if at < source.size:
                found.damage.append(f"it ends in a record that is truncated or damaged, at byte {at}")
        except BagError as problem:
            found.damage.append(problem.reason)
        return found

    def _take(self, record: Any, at: int) -> None:
        kind = type(record).__name__
        if kind == "Schema":
            self._schemas[record.id] = record
        elif kind == "Channel":
            self._learn(record)
        elif kind == "Message":
            self._loose(record, at)
        elif kind == "Statistics":
            self._stated = record.message_count
        elif kind == "Footer":
            self._footer = True
        elif kind == "Chunk":
            self._found.packed[at] = record.compression, len(record.data), record.uncompressed_size
            try:
                messages = messages_of(self._source, record, at, self._others)
            except BagError as problem:
                self._found.damage.append(f"the chunk at byte {at} is damaged and left out: {problem.reason}")
                self._found.lost = True
                return
            self._keep(at, messages)

    def _others(self, record: McapRecord) -> None:
        self._take(record, -1)

    def _learn(self, channel: Channel) -> None:
        if len(self._found.connections) >= MAX_CONNECTIONS:
            raise BagError(f"more than {MAX_CONNECTIONS} channels")
        self._found.connections[channel.id] = connection_of(channel, self._schemas.get(channel.schema_id))

    def _loose(self, message: McapMessage, at: int) -> None:
        last = self._found.chunks[-1] if self._found.chunks else None
        if last is None or last.pos not in self._found.loose or sum(last.counts.values()) >= LOOSE:
            self._found.loose.add(at)
            self._keep(at, [message])
        else:
            last.start, last.end = min(last.start, message.log_time), max(last.end, message.log_time)
            last.counts[message.channel_id] = last.counts.get(message.channel_id, 0) + 1

    def _keep(self, at: int, messages: list[McapMessage]) -> None:
        known = [m for m in messages if m.channel_id in self._found.connections]
        if len(known) < len(messages):
            self._found.lost = True
            self._found.damage.append(
                f"{len(messages) - len(known)} messages at byte {at} are of channels that are not described"
            )
        if known:
            counts = dict(Counter([message.channel_id for message in known]))
            times = [message.log_time for message in known]
            self._found.chunks.append(ChunkInfo(at, min(times), max(times), counts))


def connection_of(channel: Channel, schema: Schema | None) -> Connection:
    """A channel as a bag's connection; its metadata are the connection header."""
    header = dict(channel.metadata)
    is_ros1 = channel.message_encoding == "ros1" and schema is not None and schema.encoding == "ros1msg"
    kind = schema.name if schema is not None else ""
    definition = schema.data.decode("utf-8", "surrogateescape") if schema is not None and is_ros1 else ""
    md5sum = header.get("md5sum") or (_md5sum(kind, definition) if is_ros1 else "")
    header |= {"type": kind, "md5sum": md5sum, "message_definition": definition}
    header.setdefault("topic", channel.topic)
    return Connection(channel.id, channel.topic, kind, md5sum, definition, MappingProxyType(header))


def _md5sum(kind: str, definition: str) -> str:
    from rosproto.codec import define

    try:
        md5sum: str = define(kind, definition)._md5sum
    except DefinitionError:
        return ""
    return md5sum
