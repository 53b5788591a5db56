"""Write MCAP files: `McapWriter`, with the methods of `BagWriter` except `set_chunks`."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import BinaryIO, Literal

from rosproto.bag.inputs import (
    Stamp,
    as_raw,
    check_header,
    check_message,
    identity,
    out_of_range,
    own_text,
    seconds_and_rest,
)
from rosproto.bag.mcap.chunks import library
from rosproto.bag.messages import RawMessage
from rosproto.bag.records import NS, Connection
from rosproto.codec import Message, encode
from rosproto.errors import BagError
from rosproto.version import __version__

_OWN = ("type", "message_definition")  # part of the schema


class McapWriter:
    """An MCAP file (profile `ros1`), opened for writing, with the methods of `BagWriter` except `set_chunks`.

    Messages are stored unchanged, with their receive times as log times. A connection becomes a channel, its
    header the channel's metadata, its definition the schema. Any thread may write. The file on disk is always
    a sequence of whole chunks: a process that dies loses only the chunk it was filling, and `McapReader`
    reads the rest.

    Args:
        file: Path (an existing file is replaced), or a binary file opened for writing.
        compression: "none", "lz4" or "zstd".
        chunk_bytes: A chunk is written when its uncompressed size reaches this.

    Raises:
        BagError: The file cannot be opened, or the package mcap is missing (extra `mcap`).
        ValueError: Unknown compression, or a chunk size out of range.

    Attributes:
        path: Path of the file, None when there is none.
        message_count: Messages written so far.
    """

    def __init__(
        self,
        file: str | os.PathLike[str] | BinaryIO,
        compression: Literal["none", "lz4", "zstd"] = "none",
        chunk_bytes: int = 768 * 1024,
    ) -> None:
        if not 1 <= chunk_bytes <= 1 << 30:
            raise ValueError(f"chunk_bytes {chunk_bytes}: between 1 and {1 << 30} bytes")
        if compression not in ("none", "lz4", "zstd"):
            raise ValueError(f"compression {compression!r}: MCAP supports none, lz4, zstd")
        module = library("writer")
        self._lock = threading.RLock()
        self._channels: dict[tuple[object, ...], int] = {}
        self._raw_channels: dict[tuple[str, int], int] = {}
        self._kept: list[Connection] = []
        self._schemas: dict[tuple[str, str, str], int] = {}
        self._failed: BagError | None = None
        self._closed = False
        self._waiting = 0
        self.message_count = 0
        if isinstance(file, (str, os.PathLike)):
            self.path: str | None = os.fspath(file)
            try:
                self._file: BinaryIO = open(file, "wb")  # noqa: SIM115
            except OSError as problem:
                raise BagError(f"cannot write: {problem.strerror}", path=self.path) from problem
            self._owned = True
        else:
            name = getattr(file, "name", None)
            self.path = name if isinstance(name, str) else None
            self._file, self._owned = file, False
        kind = {"none": "NONE", "lz4": "LZ4", "zstd": "ZSTD"}[compression]
        self._writer = module.Writer(
            self._file, chunk_size=chunk_bytes, compression=module.CompressionType[kind]
        )
        self._chunk_bytes = chunk_bytes
        self._do(lambda: self._writer.start(profile="ros1", library=f"rosproto {__version__}"))

    def __enter__(self) -> McapWriter:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<McapWriter {self.path or 'stream'}: {self.message_count} messages>"

    @property
    def size(self) -> int:
        """Bytes in the file so far, plus the uncompressed bytes not yet written."""
        with self._lock:
            return (0 if self._file.closed else self._file.tell()) + self._waiting

    def write(
        self,
        topic: str,
        message: Message | RawMessage,
        t: Stamp | None = None,
        *,
        header: Mapping[str, str] | None = None,
    ) -> None:
        """Add a message; see `BagWriter.write`."""
        if not isinstance(topic, str) or not topic:
            raise ValueError(f"topic {topic!r}: a name such as /odom is needed")
        secs, nsecs = seconds_and_rest(time.time() if t is None else t)
        stamp = int(secs) * NS + int(nsecs)
        if not 0 <= stamp < 1 << 64:
            raise out_of_range(0.0 if t is None else t)
        if isinstance(message, RawMessage):
            data = bytes(message.data)
        else:
            check_message(topic, message)
            if message._type == "*":
                message = as_raw(topic, message)
                data = message.data
            else:
                data = encode(message)
        with self._lock:
            if self._failed is not None:
                raise self._failed
            if self._closed:
                raise BagError("the file is closed", path=self.path)
            channel = self._channel(topic, message, header)
            self._do(
                lambda: self._writer.add_message(
                    channel_id=channel, log_time=stamp, publish_time=stamp, data=data
                )
            )
            self.message_count += 1
            self._waiting += len(data) + 31
            if self._waiting >= self._chunk_bytes:
                self._waiting = 0

    def write_raw(self, connection: Connection, data: bytes, t: Stamp) -> None:
        """Add a serialized message; see `BagWriter.write_raw`."""
        raw = RawMessage(connection.type, data, connection.md5sum, (0, 0), connection)
        self.write(connection.topic, raw, t)

    def flush(self) -> None:
        """Write the chunk being filled, however small, so that readers of the file can see it.

        Raises:
            BagError: The file cannot be written.
        """
        with self._lock:
            if self._failed is not None:
                raise self._failed
            if not self._closed:
                self._do(self._writer.flush)
                self._waiting = 0

    def close(self) -> None:
        """Write the last chunk and the summary, and close the file.

        Raises:
            BagError: The file cannot be written; it is closed anyway.
        """
        with self._lock:
            if self._closed:
                return
            self._closed = True
            try:
                if self._failed is None:
                    self._do(self._finish)
            finally:
                if self._owned:
                    try:
                        self._file.close()
                    except OSError:  # flushing its buffer; the failure was reported already
                        if self._failed is None:
                            raise

    def _finish(self) -> None:
        self._writer.finish()
        self._file.flush()

    def _do(self, act: Callable[[], object]) -> None:
        try:
            act()
        except OSError as problem:
            self._failed = BagError(
                f"cannot write: {problem.strerror}; the complete chunks in the file are readable",
                path=self.path,
            )
            raise self._failed from problem

    # -- channels ----------------------------------------------------------------------------------------

    def _channel(self, topic: str, message: Message | RawMessage, header: Mapping[str, str] | None) -> int:
        if isinstance(message, RawMessage):
            given = message.connection
            known = self._raw_channels.get((topic, id(given))) if header is None else None
            if known is not None:
                return known
            number = self._number(
                replace(given, topic=topic, header=given.header if header is None else header)
            )
            if header is None:
                self._raw_channels[topic, id(given)] = number
                self._kept.append(given)  # otherwise another object could get the same id
            return number
        if header is not None:
            check_header(header)
        cls = message.__class__
        definition = own_text(cls, header) or cls._full_text
        return self._number(Connection(-1, topic, cls._type, cls._md5sum, definition, header or {}))

    def _number(self, connection: Connection) -> int:
        """The channel of a connection, made if new.

        Raises:
            BagError: Its header is not UTF-8, which MCAP requires.
        """
        key = identity(connection)
        if key in self._channels:
            return self._channels[key]
        metadata = {name: text for name, text in connection.header.items() if name not in _OWN}
        if metadata.get("topic") == connection.topic:
            del metadata["topic"]
        metadata["md5sum"] = connection.md5sum
        try:
            for text in (connection.topic, connection.type, *metadata, *metadata.values()):
                text.encode()
        except UnicodeEncodeError:
            raise BagError(
                f"{connection.topic!a}: its connection header is not UTF-8, and MCAP stores nothing else",
                path=self.path,
            ) from None
        if len(self._channels) >= 0xFFFF:
            raise BagError("more than 65535 channels do not fit into one MCAP file", path=self.path)
        number: int = self._writer.register_channel(
            topic=connection.topic,
            message_encoding="ros1",
            schema_id=self._schema(connection),
            metadata=metadata,
        )
        self._channels[key] = number
        return number

    def _schema(self, connection: Connection) -> int:
        key = (connection.type, connection.md5sum, connection.definition)
        if key not in self._schemas:
            text = connection.definition.encode("utf-8", "surrogateescape")
            self._schemas[key] = self._writer.register_schema(
                name=connection.type, encoding="ros1msg", data=text
            )
        return self._schemas[key]
