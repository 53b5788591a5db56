"""Write bags that every ROS 1 tool reads.

Messages are collected in memory until a chunk is full; then the chunk and its index records are written to
the file at once (helper threads compress it while the next one is filled). So the file on disk is always a
sequence of complete chunks. A process that dies loses only the chunk it was filling and those being
compressed; `BagReader` reads the rest directly, rosbag after `rosbag reindex`. `close()` adds the table
of contents.
"""

from __future__ import annotations

import os
import threading
import time
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from struct import Struct, error
from typing import Any, BinaryIO, Literal

from rosproto.bag.bag_file import BagFile, system_errors
from rosproto.bag.compression import compressor
from rosproto.bag.index_section import open_index
from rosproto.bag.inputs import (
    as_raw,
    check_header,
    check_message,
    data_of,
    identity,
    out_of_range,
    own_text,
    seconds_and_rest,
)
from rosproto.bag.message_offsets import MESSAGE_HEAD
from rosproto.bag.messages import RawMessage
from rosproto.bag.output import BagOutputFile, ChunkWriter
from rosproto.bag.records import (
    MAGIC,
    NS,
    OP_MESSAGE,
    ChunkInfo,
    Connection,
    FileHeader,
    encode_contents,
    encode_index,
)
from rosproto.bag.unindexed_scan import BagIndex
from rosproto.codec import Message, encoder
from rosproto.errors import BagError
from rosproto.sentence import say
from rosproto.time import Time

_pack_tail = Struct("<III").pack  # secs, nsecs, size of the data: the end of a message record's head
_FEW = 64  # messages of one connection in a chunk, up to which a plain loop beats numpy


class _OutgoingConnection:
    """A connection that is being written.

    Attributes:
        connection: Its record; the first message assigns the id.
        encode: Serializes a message.
        head: The bytes of every message record up to the time; empty until the first message.
        index: secs, nsecs and offset of each message in the chunk being filled.
    """

    __slots__ = ("connection", "encode", "head", "index")

    def __init__(self, connection: Connection, encode: Callable[[Any], bytes]) -> None:
        self.connection = connection
        self.encode = encode
        self.head = b""
        self.index: list[int] = []


class BagWriter:
    """A bag, opened for writing. Any thread may write: callbacks of several subscribers share one.

    Args:
        file: Path (an existing file is replaced, unless `append`), or a seekable binary file opened for
            writing (and reading, for append).
        compression: "none", "bz2" or "lz4".
        chunk_bytes: A chunk is written when its uncompressed size reaches this.
        append: Continue an existing bag; its table of contents is rewritten on close.

    Raises:
        BagError: The file cannot be opened; to append: it is not a sound bag (run `reindex` first).
        ValueError: Unknown compression, or a chunk size out of range.

    Attributes:
        path: Path of the file, None when there is none.
        message_count: Messages written so far (by this writer).
    """

    def __init__(
        self,
        file: str | os.PathLike[str] | BinaryIO,
        compression: Literal["none", "bz2", "lz4"] = "none",
        chunk_bytes: int = 768 * 1024,
        *,
        append: bool = False,
    ) -> None:
        self._limit = _chunk_limit(chunk_bytes)
        self._compression = compression
        with system_errors(os.fspath(file) if isinstance(file, (str, os.PathLike)) else None):
            compress = compressor(compression)
        self._outs: dict[tuple[str, type], _OutgoingConnection] = {}
        self._raw_outs: dict[tuple[str, int], _OutgoingConnection] = {}
        self._by_identity: dict[tuple[object, ...], _OutgoingConnection] = {}
        self._kept: list[Connection] = []
        self._written: list[_OutgoingConnection] = []
        self._parts: list[bytes] = []
        self._size = 0
        self._index = BagIndex()
        self._failed: BagError | None = None
        # Several callbacks write to one bag. Reentrant: a signal handler may close it during a write.
        self._lock = threading.RLock()
        self.message_count = 0
        self._closed = False
        self._output = BagOutputFile(file, keep=append)
        self.path = self._output.path
        self._chunks = ChunkWriter(self._output, compression, compress)
        try:
            self._resume() if self._output.existed else self._start()
            self._chunks.end, self._chunks.chunks = self._index.end, self._index.chunks
        except BaseException:
            self._output.close()
            raise

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<BagWriter {self.path or 'stream'}: {self.message_count} messages, {self._compression}>"

    @property
    def size(self) -> int:
        """Bytes in the file so far, plus the uncompressed bytes not yet written."""
        return self._chunks.size + self._size

    def write(
        self,
        topic: str,
        message: Message | RawMessage,
        t: Time | float | None = None,
        *,
        header: Mapping[str, str] | None = None,
    ) -> None:
        """Add a message. It is serialized before this returns.

        Args:
            topic: Topic to store it under.
            message: A message, or a raw one of `BagReader.read_messages(raw=True)` or a raw subscriber; its
                type, definition and connection header are then stored as they are.
            t: Receive time: Time, or seconds since 1970; None is now.
            header: The publisher's connection header to store (callerid, latching), and with it the
                publisher's own definition text, if it is the same definition. One connection is written for
                each different one.

        Raises:
            BagError: The file cannot be written; it stays readable up to its last whole chunk.
            CodecError: A value does not fit its field; nothing was added.
            ValueError: The time, the topic or the header is invalid, or the time is out of range.
            TypeError: `message` is not a message.
        """
        if t is None:
            t = time.time()
        try:
            if isinstance(t, (int, float)):
                secs, nsecs = divmod(round(t * NS), NS)
            else:
                secs, nsecs = t.secs, t.nsecs
        except (AttributeError, ValueError, OverflowError):
            secs, nsecs = seconds_and_rest(t)
        with self._lock:
            if message.__class__ is RawMessage:
                out = self._raw_outs.get((topic, id(message.connection)))
            else:
                out = self._outs.get((topic, message.__class__))
            if out is None or header is not None:
                out, message = self._find_out(topic, message, header)
            data = out.encode(message)
            size = len(data)
            try:
                tail = _pack_tail(secs, nsecs, size)
            except error:
                raise out_of_range(t) from None
            if not out.head:
                self._announce(out)
            offset = self._size
            out.index += (secs, nsecs, offset)
            self._parts += (out.head, tail, data)
            self.message_count += 1
            self._size = offset = offset + MESSAGE_HEAD + size
            if offset >= self._limit:
                self._flush()

    def write_raw(self, connection: Connection, data: bytes, t: Time | float) -> None:
        """Add a serialized message.

        Args:
            connection: Topic, type, md5sum, definition and header to store it under; its `id` is not used.
            data: Serialized message.
            t: Receive time: Time, or seconds since 1970.
        """
        raw = RawMessage(connection.type, data, connection.md5sum, (0, 0), connection)
        self.write(connection.topic, raw, t)

    def set_chunks(self, compression: Literal["none", "bz2", "lz4"], chunk_bytes: int) -> None:
        """Write the chunk being filled; later ones get this compression and size.

        Raises:
            BagError: The file cannot be written.
            ValueError: Unknown compression, or a chunk size out of range; nothing is changed.
        """
        limit = _chunk_limit(chunk_bytes)
        with system_errors(self.path):
            compress = compressor(compression)
        with self._lock:
            self.flush()
            self._chunks.set_compression(compression, compress)
            self._compression, self._limit = compression, limit

    def flush(self) -> None:
        """Write the chunk being filled, however small, so that readers of the file can see it.

        Raises:
            BagError: The file cannot be written.
        """
        with self._lock:
            self._check_open()
            self._flush()
            self._chunks.drain()
            self._check_written()

    def close(self) -> None:
        """Write the last chunk and the table of contents, and close the file.

        Raises:
            BagError: The file cannot be written; it is closed anyway.
        """
        with self._lock:
            if self._closed:
                return
            self._closed = True
            self._forget()
            try:
                if self._failed is None:
                    self._flush()
                self._chunks.drain()
                if self._failed is None:
                    self._check_written()
                self._finish()
            finally:
                self._output.close()

    # -- connections -------------------------------------------------------------------------

    def _find_out(
        self, topic: str, message: Message | RawMessage, header: Mapping[str, str] | None
    ) -> tuple[_OutgoingConnection, Message | RawMessage]:
        """The connection of a message, made if new."""
        self._check_open()
        if not isinstance(topic, str) or not topic:
            raise ValueError(say("topic {topic!r}: a name such as /odom is needed", topic=topic))
        if header is not None:
            check_header(header)
        if isinstance(message, RawMessage):
            given = message.connection
            out = self._out(
                replace(given, topic=topic, header=given.header if header is None else header), data_of
            )
            if header is None:
                self._raw_outs[topic, id(given)] = out
                self._kept.append(given)  # otherwise another object could get the same id
            return out, message
        check_message(topic, message)
        cls = message.__class__
        if cls._type == "*":
            return self._find_out(topic, as_raw(topic, message), header)
        definition = own_text(cls, header) or cls._full_text
        with system_errors(self.path):
            encode = encoder(cls)
        out = self._out(Connection(-1, topic, cls._type, cls._md5sum, definition, header or {}), encode)
        if header is None:
            self._outs[topic, cls] = out
        return out, message

    def _out(self, connection: Connection, encode: Callable[[Any], bytes]) -> _OutgoingConnection:
        """The `_OutgoingConnection` of an equal connection, or a new one when this bag has none yet."""
        key = identity(connection)
        out = self._by_identity.get(key)
        if out is None or out.encode is not encode:
            out = _OutgoingConnection(connection, encode)
            self._by_identity.setdefault(key, out)
        return out

    def _announce(self, out: _OutgoingConnection) -> None:
        """Give a connection its id and write its record in front of its first message."""
        key = identity(out.connection)
        known = self._by_identity.setdefault(key, out)
        if known.head:  # the same connection by another class
            out.connection, out.head, out.index = known.connection, known.head, known.index
            return
        self._by_identity[key] = out
        number = max(self._index.connections, default=-1) + 1
        out.connection = replace(out.connection, id=number)
        record = out.connection.encode()
        self._index.connections[number] = out.connection
        out.head = _message_head(number)
        self._written.append(out)
        self._parts.append(record)
        self._size += len(record)

    # -- the file ----------------------------------------------------------------------------

    def _start(self) -> None:
        head = MAGIC + FileHeader().encode()
        self._put([head], at=0)
        self._index.end = len(head)

    def _resume(self) -> None:
        """Take over the contents of an existing bag and truncate its table of contents."""
        found = open_index(BagFile(self._output.file))
        if found.damage or not found.closed:
            raise BagError(
                f"cannot append: {'; '.join(found.damage) or 'the bag has no index'}. Repair it first with "
                "`rosproto bag reindex`",
                path=self.path,
            )
        self._index = found
        for connection in found.connections.values():
            out = _OutgoingConnection(connection, data_of)
            out.head = _message_head(connection.id)
            self._written.append(out)
            self._by_identity[identity(connection)] = out
        self._put([FileHeader().encode()], at=found.head)  # from here on it is an unclosed bag
        self._output.truncate(found.end)

    def _flush(self) -> None:
        """Pass the filled chunk to the output."""
        if not self._parts:
            return
        info = ChunkInfo(0, 0, 0)
        try:
            indexes = self._take_index(info)
        except (OSError, ImportError) as problem:  # importing numpy needs free file descriptors
            raise self._fail(problem) from problem
        parts, size = self._parts, self._size
        self._parts, self._size = [], 0
        self._chunks.add(info, size, parts, indexes)
        self._check_written()

    def _take_index(self, info: ChunkInfo) -> bytes:
        """Index records of the chunk, times in order; counts and time span go into `info`."""
        records: list[bytes] = []
        spans: list[tuple[int, int]] = []
        for out in self._written:
            if not out.index:
                continue
            entries, start, end = _index_entries(out.index)
            info.counts[out.connection.id] = len(out.index) // 3
            out.index.clear()
            spans.append((start, end))
            records.append(encode_index(out.connection.id, entries))
        if spans:
            info.start, info.end = min(s for s, _ in spans), max(e for _, e in spans)
        return b"".join(records)

    def _finish(self) -> None:
        """Write the table of contents, then the file header that points to it; in this order, a crash in
        between leaves an unclosed bag."""
        index, end = self._index, self._chunks.end
        self._put([encode_contents(index.connections.values(), index.chunks)], at=end)
        self._put([FileHeader(end, len(index.connections), len(index.chunks)).encode()], at=index.head)

    def _put(self, pieces: Sequence[bytes], *, at: int) -> None:
        try:
            self._output.put(pieces, at)
        except OSError as problem:
            raise self._fail(problem) from problem

    def _check_written(self) -> None:
        problem = self._chunks.problem
        if problem is not None:
            raise self._fail(problem) from problem

    def _fail(self, problem: BaseException) -> BagError:
        """Store the failure, which refuses later writes."""
        self._forget()
        lost, end = self.message_count - self._chunks.messages, self._chunks.end
        why = (problem.strerror if isinstance(problem, OSError) else None) or problem
        text = (
            "cannot write: {why}; {lost} messages were not in the file yet and are lost, the bag is "
            "readable up to byte {at}"
        )
        self._failed = BagError(say(text, why=why, lost=lost, at=end), path=self.path, offset=end)
        return self._failed

    def _forget(self) -> None:
        """Make later writes look up their connection again, which checks for a closed bag."""
        self._outs.clear()
        self._raw_outs.clear()

    def _check_open(self) -> None:
        if self._failed is not None:
            raise self._failed
        if self._closed:
            raise BagError("the bag is closed", path=self.path)


def _message_head(connection_id: int) -> bytes:
    """A message record up to the time's value: header length, conn, op, and the time field's name."""
    u32 = Struct("<I").pack
    conn = u32(9) + b"conn=" + u32(connection_id)
    return u32(38) + conn + u32(4) + b"op=" + bytes([OP_MESSAGE]) + u32(13) + b"time="


def _index_entries(flat: list[int]) -> tuple[bytes, int, int]:
    """The entries of an index record, sorted by time, and the first and last time."""
    if len(flat) <= 3 * _FEW:
        times = [secs * NS + nsecs for secs, nsecs in zip(flat[0::3], flat[1::3], strict=True)]
        if times == sorted(times):
            return Struct(f"<{len(flat)}I").pack(*flat), times[0], times[-1]
    import numpy as np

    table = np.array(array("I", flat), "<u4").reshape(-1, 3)
    stamps = table[:, 0].astype(np.int64) * NS + table[:, 1]
    if (stamps[1:] < stamps[:-1]).any():  # rosbag does a binary search in it
        table = table[np.argsort(stamps, kind="stable")]
    return table.tobytes(), int(stamps.min()), int(stamps.max())


def _chunk_limit(chunk_bytes: int) -> int:
    if not 1 <= chunk_bytes <= 1 << 30:
        raise ValueError(f"chunk_bytes {chunk_bytes}: between 1 and {1 << 30} bytes")
    return chunk_bytes
