"""Records of the bag format 2.0: bytes to values and back, without touching a file.

A bag is the line `#ROSBAG V2.0`, then records. A record is a header (length, then fields `name=value`, each
with its own length) and data (length, bytes); all integers little-endian. The `op` field is its kind:

    file header   where the index section begins; padded with blanks to 4096 bytes, to be rewritten in place
    chunk         many message and connection records, compressed together
    index data    after a chunk, one for each connection in it: times and uncompressed offsets of its messages
    connection    topic, type, definition: inside the chunk that first needs it, and again at the end
    chunk info    at the end, one for each chunk: position, time span, message counts
    message       connection id, receive time, serialized message

Fields may be in any order; only C++ rosbag sorts them.

Source: wiki.ros.org/Bags/Format/2.0; rosbag/bag.py and rosbag_storage/bag.cpp where it is silent.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from struct import Struct, error
from types import MappingProxyType

from rosproto.errors import BagError

MAGIC = b"#ROSBAG V2.0\n"
OP_MESSAGE = 2
OP_FILE_HEADER = 3
OP_INDEX = 4
OP_CHUNK = 5
OP_CHUNK_INFO = 6
OP_CONNECTION = 7

INDEX_ENTRY_BYTES = 12
FILE_HEADER_BYTES = 4096
NS = 1_000_000_000

_U32 = Struct("<I")
_U64 = Struct("<Q")
_TIME = Struct("<II")


def encode_fields(fields: Mapping[str, bytes]) -> bytes:
    """Encode a header: its own length, then every field with its length, in the given order."""
    parts = [b"%s=%s" % (name.encode(), value) for name, value in fields.items()]
    body = b"".join([_U32.pack(len(part)) + part for part in parts])
    return _U32.pack(len(body)) + body


def encode_record(fields: Mapping[str, bytes], data: bytes = b"") -> bytes:
    """Encode a whole record."""
    return encode_fields(fields) + _U32.pack(len(data)) + data


def decode_fields(data: bytes | memoryview, start: int, end: int) -> dict[str, bytes]:
    """The fields of a header.

    Args:
        data: Bytes that hold it.
        start: First byte after the header's own length.
        end: First byte after the header.

    Raises:
        BagError: The bytes are not a header.
    """
    fields: dict[str, bytes] = {}
    at = start
    while at < end:
        if at + 4 > end:
            raise BagError("a record header ends inside a field length; the file is damaged here", offset=at)
        (size,) = _U32.unpack_from(data, at)
        at += 4
        if size > end - at:
            raise BagError(
                f"a record header has a field of {size} bytes, but {end - at} are left; the file is damaged",
                offset=at,
            )
        name, equals, value = bytes(data[at : at + size]).partition(b"=")
        if not equals:
            raise BagError("a record header has a field without '='; the file is damaged here", offset=at)
        fields[name.decode("latin-1")] = value
        at += size
    return fields


def decode_text_fields(data: bytes, start: int, end: int) -> dict[str, str]:
    """The connection header in a connection record, as text; undecodable bytes are kept reversibly."""
    fields = decode_fields(data, start, end)
    return {name: value.decode("utf-8", "surrogateescape") for name, value in fields.items()}


def op_of(fields: Mapping[str, bytes]) -> int:
    """The op code, -1 when the header has none."""
    op = fields.get("op", b"")
    return op[0] if len(op) == 1 else -1


def _values(fields: Mapping[str, bytes], name: str, layout: Struct) -> tuple[int, ...]:
    try:
        return layout.unpack(fields[name])
    except (KeyError, error):
        raise BagError(f"a record lacks a proper {name!r} field; the file is damaged here") from None


def _number(fields: Mapping[str, bytes], name: str, layout: Struct) -> int:
    return _values(fields, name, layout)[0]


def _time(fields: Mapping[str, bytes], name: str) -> int:
    secs, nsecs = _values(fields, name, _TIME)
    return secs * NS + nsecs


def _pack_time(time_ns: int) -> bytes:
    # A damaged bag may contain nsecs of 10**9 or more; the carry must not overflow secs.
    secs, nsecs = divmod(time_ns, NS)
    return _TIME.pack(min(secs, 0xFFFFFFFF), nsecs)


@dataclass(frozen=True, slots=True)
class FileHeader:
    """The first record.

    Attributes:
        index_pos: Where the index section starts; 0 when the bag was never closed.
        connection_count: How many connection records it has.
        chunk_count: How many chunk info records follow them.
        encryptor: Name of the encryption plug-in; "" for a plain bag.
    """

    index_pos: int = 0
    connection_count: int = 0
    chunk_count: int = 0
    encryptor: str = ""

    @staticmethod
    def from_fields(fields: Mapping[str, bytes]) -> FileHeader:
        """Decode; BagError when a field is missing."""
        return FileHeader(
            _number(fields, "index_pos", _U64),
            _number(fields, "conn_count", _U32),
            _number(fields, "chunk_count", _U32),
            fields.get("encryptor", b"").decode("utf-8", "replace"),
        )

    def encode(self) -> bytes:
        """The whole record, padded to a fixed size, so that it can be rewritten in place."""
        header = encode_fields(
            {
                "chunk_count": _U32.pack(self.chunk_count),
                "conn_count": _U32.pack(self.connection_count),
                "index_pos": _U64.pack(self.index_pos),
                "op": bytes([OP_FILE_HEADER]),
            }
        )
        padding = FILE_HEADER_BYTES - (len(header) - 4)
        return header + _U32.pack(padding) + b" " * padding


@dataclass(frozen=True, slots=True)
class Connection:
    """One publisher of one topic, as recorded.

    Attributes:
        id: Number used by the message records.
        topic: Topic the messages are stored under.
        type: "package/Type".
        md5sum: Of the definition.
        definition: Full definition text.
        header: The publisher's connection header (may hold callerid, latching, ...). Its `topic` is the
            one it was published under, which differs from `topic` after a remapping or filter.
    """

    id: int
    topic: str
    type: str
    md5sum: str
    definition: str = field(repr=False)
    header: Mapping[str, str] = field(repr=False, default_factory=lambda: MappingProxyType({}))

    @property
    def callerid(self) -> str:
        """Name of the publishing node; "" when not recorded."""
        return self.header.get("callerid", "")

    @property
    def latching(self) -> bool:
        """Whether the topic was latched."""
        return self.header.get("latching", "") == "1"

    def encode(self) -> bytes:
        """The whole connection record."""
        header = {**self.header, "topic": self.header.get("topic", self.topic)}
        header |= {"type": self.type, "md5sum": self.md5sum, "message_definition": self.definition}
        data = encode_fields({k: v.encode("utf-8", "surrogateescape") for k, v in sorted(header.items())})[4:]
        topic = self.topic.encode("utf-8", "surrogateescape")
        return encode_record({"conn": _U32.pack(self.id), "op": bytes([OP_CONNECTION]), "topic": topic}, data)


def connection_from_fields(fields: Mapping[str, bytes], header: Mapping[str, str]) -> Connection:
    """A connection from its record's header fields and its data.

    Raises:
        BagError: A required field is missing.
    """
    if "topic" not in fields:
        raise BagError("a connection record names no topic; the file is damaged here")
    missing = [name for name in ("type", "md5sum") if name not in header]
    if missing:
        raise BagError(f"a connection record lacks {' and '.join(missing)}; the file is damaged here")
    return Connection(
        _number(fields, "conn", _U32),
        fields["topic"].decode("utf-8", "surrogateescape"),
        header["type"],
        header["md5sum"],
        header.get("message_definition", ""),
        MappingProxyType(dict(header)),
    )


@dataclass(frozen=True, slots=True)
class ChunkHeader:
    """Header of a chunk record: compression "none", "bz2" or "lz4", and the size once uncompressed."""

    compression: str
    size: int

    @staticmethod
    def from_fields(fields: Mapping[str, bytes]) -> ChunkHeader:
        """Decode; BagError when a field is missing."""
        if "compression" not in fields:
            raise BagError("a chunk record names no compression; the file is damaged here")
        return ChunkHeader(fields["compression"].decode("latin-1"), _number(fields, "size", _U32))

    def encode(self, data_bytes: int) -> bytes:
        """The record up to its data, of which `data_bytes` follow."""
        fields = {
            "compression": self.compression.encode(),
            "op": bytes([OP_CHUNK]),
            "size": _U32.pack(self.size),
        }
        return encode_fields(fields) + _U32.pack(data_bytes)


@dataclass(slots=True)
class ChunkInfo:
    """Contents of a chunk.

    Attributes:
        pos: Byte position of the chunk record in the file.
        start: Earliest receive time in it, ns.
        end: Latest receive time, ns.
        counts: Messages by connection id.
        indexed: True when complete index records follow the chunk.
        partial: True when the chunk itself is cut off.
    """

    pos: int
    start: int
    end: int
    counts: dict[int, int] = field(default_factory=dict)
    indexed: bool = True
    partial: bool = False

    @staticmethod
    def from_record(fields: Mapping[str, bytes], data: bytes) -> ChunkInfo:
        """Decode; BagError when it is malformed."""
        count = _number(fields, "count", _U32)
        if len(data) < 8 * count:
            raise BagError(f"a chunk info record says {count} connections, but has {len(data)} bytes")
        pairs = [_TIME.unpack_from(data, 8 * i) for i in range(count)]
        return ChunkInfo(
            _number(fields, "chunk_pos", _U64),
            _time(fields, "start_time"),
            _time(fields, "end_time"),
            dict(pairs),
        )

    def encode(self) -> bytes:
        """The whole chunk info record."""
        fields = {
            "chunk_pos": _U64.pack(self.pos),
            "count": _U32.pack(len(self.counts)),
            "end_time": _pack_time(self.end),
            "op": bytes([OP_CHUNK_INFO]),
            "start_time": _pack_time(self.start),
            "ver": _U32.pack(1),
        }
        return encode_record(fields, b"".join([_TIME.pack(*pair) for pair in self.counts.items()]))


def encode_index(connection_id: int, entries: bytes) -> bytes:
    """An index data record.

    Args:
        connection_id: The connection.
        entries: For each message: secs, nsecs and offset in the uncompressed chunk, uint32 each.
    """
    fields = {
        "conn": _U32.pack(connection_id),
        "count": _U32.pack(len(entries) // INDEX_ENTRY_BYTES),
        "op": bytes([OP_INDEX]),
        "ver": _U32.pack(1),
    }
    return encode_record(fields, entries)


def index_header(fields: Mapping[str, bytes]) -> tuple[int, int]:
    """Connection id and entry count of an index data record; BagError when it is malformed."""
    version = _number(fields, "ver", _U32)
    if version != 1:
        raise BagError(
            f"an index record has version {version}, expected 1; the bag was written by a newer tool"
        )
    return _number(fields, "conn", _U32), _number(fields, "count", _U32)


def message_header(fields: Mapping[str, bytes]) -> tuple[int, int, int]:
    """Connection id, secs and nsecs of a message record; BagError when it is malformed."""
    secs, nsecs = _values(fields, "time", _TIME)
    return _number(fields, "conn", _U32), secs, nsecs


def encode_contents(connections: Iterable[Connection], chunks: Iterable[ChunkInfo]) -> bytes:
    """The table of contents that ends a bag: connection records, then chunk info records."""
    records = [c.encode() for c in sorted(connections, key=lambda c: c.id)]
    return b"".join(records + [chunk.encode() for chunk in chunks])


def total_counts(chunks: Iterable[ChunkInfo]) -> dict[int, int]:
    """Messages by connection id over all chunks."""
    totals: Counter[int] = Counter()
    for chunk in chunks:
        totals.update(chunk.counts)
    return totals
