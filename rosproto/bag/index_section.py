"""Open a bag: read the index section at its end, or call `unindexed_scan` if that section is unusable.

A bag that was closed properly ends with its connection records and one chunk info record for each chunk; the
file header says where they start. Only these are read, so a bag of any size opens quickly. The file is never
changed here (see `repair`).
"""

from __future__ import annotations

import re
from struct import Struct

from rosproto.bag.bag_file import MAX_CONNECTIONS, BagFile
from rosproto.bag.chunk import read_head
from rosproto.bag.records import (
    MAGIC,
    OP_CHUNK_INFO,
    OP_CONNECTION,
    OP_FILE_HEADER,
    ChunkInfo,
    FileHeader,
    connection_from_fields,
    decode_fields,
    decode_text_fields,
    op_of,
)
from rosproto.bag.unindexed_scan import BagIndex, scan
from rosproto.errors import BagError
from rosproto.sentence import say

_U32 = Struct("<I")
_BLOCK = 4 << 20  # read at once; the index sections of most bags are smaller
_NO_BAGS = {
    b"\x89MCAP0": "this is MCAP",
    b"SQLite format 3": "this is a bag of ROS 2",
    b"version https://git-lfs": "this stands in for the file until `git lfs pull`",
    b"PK\x03\x04": "this is a ZIP archive, unpack it first",
    b"\x1f\x8b": "this is packed with gzip, unpack it first",
    b"<": "this is a web page: a login, or the page about the file",
    b"BZh": "this is packed with bzip2, unpack it first",
    b"\x28\xb5\x2f\xfd": "this is packed with zstd, unpack it first",
}
"""Files that are mistaken for bags, by their first bytes."""


def open_index(source: BagFile) -> BagIndex:
    """Read the contents of a bag from its index, or from a scan.

    Args:
        source: The file.

    Raises:
        BagError: The file is not a bag, or is of version 1 or encrypted.
    """
    version, start = _read_version(source)
    found = _open_behind(source, start)
    found.version, found.head = version, start
    return found


def _open_behind(source: BagFile, start: int) -> BagIndex:
    """`open_index` after the version line."""
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
        text = "the bag is encrypted with {encryptor}; decrypt it where the key is: rosbag decompress"
        raise source.error(say(text, encryptor=header.encryptor))
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


def _nothing_follows(source: BagFile, header: FileHeader, first: int) -> BagIndex:
    """The contents of a file that ends with its file header: an empty bag, or the start of one cut off."""
    found = BagIndex(end=min(first, source.size), closed=first == header.index_pos == source.size)
    if first > source.size:
        found.damage.append(f"the file ends inside its file header, at byte {source.size}")
        found.resumed = True
    elif header.index_pos == 0:
        found.damage.append("the bag was never closed, and holds no messages")
    elif not found.closed:
        found.damage.append(f"the file ends after its header, its index should be at byte {header.index_pos}")
    return found


def _without_file_header(source: BagFile, start: int, problem: BagError) -> BagIndex:
    found = scan(source, start)
    found.resumed = True
    found.damage.insert(0, f"the file header is damaged: {problem}")
    return found


def _read_version(source: BagFile) -> tuple[str, int]:
    """Version of the format, and where the first record begins; any 2.x is read, as rosbag does."""
    line = source.read_at(0, 64)
    if line.startswith(MAGIC):
        return "2.0", len(MAGIC)
    if not line:
        raise source.error("the file is empty")
    version = re.match(rb"#ROS\w* V(\d+\.\d+)[^\n]*\n?", line)
    if version is None:
        if MAGIC.startswith(line):
            text = "the file ends after {count} bytes, inside the version line"
            raise source.error(say(text, count=len(line)))
        other = next((f"; {what}" for start, what in _NO_BAGS.items() if line.startswith(start)), "")
        raise source.error(f"not a bag: it starts with {line[:16]!r}, expected {MAGIC[:-1]!r}{other}")
    number = version.group(1).decode()
    if number.startswith("2."):
        return number, version.end()
    raise source.error(
        f"bag version {number} ({line.splitlines()[0].decode('latin-1')!r}); only 2.x is read"
        + (". Convert it where ROS is installed: rosbag fix" if number < "2.0" else "")
    )


def _read_index_section(source: BagFile, header: FileHeader, first: int) -> BagIndex:
    """Connections and chunk infos at the end of the file; BagError if they are inconsistent."""
    pos = header.index_pos
    if not first <= pos <= source.size:
        raise source.error(f"index_pos {pos} is outside the file of {source.size} bytes")
    found = BagIndex(end=pos, closed=True)
    section, at = b"", 0
    # As in rosbag, the file header's counts decide: bytes behind that many records do not belong to the bag.
    for _ in range(header.connection_count + header.chunk_count):
        while (ends := _record_ends(section, at)) is None:
            left = len(section) - at
            pos, at, section = pos + at, 0, source.read_at(pos + at, max(_BLOCK, 2 * left))
            if len(section) <= left:
                raise source.error("the index section is truncated", pos)
        try:
            _add_record(section, at, *ends, found)
        except BagError as problem:
            raise source.error(str(problem), pos + at) from None
        at = ends[1]
    found.trailing_bytes = source.size - pos - at
    if (len(found.connections), len(found.chunks)) != (header.connection_count, header.chunk_count):
        raise source.error(
            f"the index has {len(found.connections)} connections and {len(found.chunks)} chunks, "
            f"the file header says {header.connection_count} and {header.chunk_count}"
        )
    found.chunks.sort(key=lambda chunk: chunk.pos)
    positions = [chunk.pos for chunk in found.chunks]
    if positions and not first <= positions[0] <= positions[-1] < found.end:
        raise source.error("the index names chunks outside the file's chunks")
    known = all(chunk.counts.keys() <= found.connections.keys() for chunk in found.chunks)
    if len(set(positions)) != len(positions) or not known:
        raise source.error("the index names a chunk twice, or messages of a connection that is not listed")
    return found


def _record_ends(section: bytes, at: int) -> tuple[int, int] | None:
    """Where the header and the data of the record at `at` end; None if the section ends before."""
    if at + 8 > len(section):
        return None
    header_end: int = at + 4 + _U32.unpack_from(section, at)[0]
    if header_end + 4 > len(section):
        return None
    end: int = header_end + 4 + _U32.unpack_from(section, header_end)[0]
    return (header_end, end) if end <= len(section) else None


def _add_record(section: bytes, at: int, header_end: int, end: int, found: BagIndex) -> None:
    """Add one record of the index section to `found`."""
    fields = decode_fields(section, at + 4, header_end)
    op = op_of(fields)
    if op == OP_CONNECTION:
        connection = connection_from_fields(fields, decode_text_fields(section, header_end + 4, end))
        found.connections[connection.id] = connection
        if len(found.connections) > MAX_CONNECTIONS:
            raise BagError(f"more than {MAX_CONNECTIONS} connections")
    elif op == OP_CHUNK_INFO:
        found.chunks.append(ChunkInfo.from_record(fields, section[header_end + 4 : end]))
    else:
        raise BagError(f"a record with op {op} in the index section")
