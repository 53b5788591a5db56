"""Write repaired bags: `reindex` adds an index section to the file itself, `recover` makes a new bag.

`rosproto bag reindex` and `rosproto bag fix` call these; readers of a damaged bag do not need them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import BinaryIO, Literal

from rosproto.bag.bag_file import BagFile, Scanning
from rosproto.bag.compression import COMPRESSIONS
from rosproto.bag.index_section import open_index
from rosproto.bag.messages import RawMessage
from rosproto.bag.opening import create_bag, open_bag
from rosproto.bag.reader import BagReader
from rosproto.bag.records import ChunkInfo, FileHeader, encode_contents
from rosproto.bag.remote import is_remote
from rosproto.bag.unindexed_scan import BagIndex
from rosproto.bag.writer import BagWriter
from rosproto.errors import BagError
from rosproto.sentence import say
from rosproto.time import Time

Path = str | os.PathLike[str]
File = Path | BinaryIO


@dataclass(frozen=True, slots=True)
class Report:
    """The result of a repair.

    Attributes:
        messages: Messages in the repaired bag.
        damage: Descriptions of the damage.
    """

    messages: int
    damage: tuple[str, ...]


def reindex(path: File, *, scanning: Scanning | None = None) -> Report:
    """Add a table of contents, in place, to a bag that was never closed or is truncated.

    All complete messages are kept: those of a cut-off last chunk are written again as a separate chunk. A
    sound bag stays unchanged, as does one that cannot be repaired (because the disk is still full).

    Args:
        path: The file, or a file object open for reading and writing, which stays open.
        scanning: Called from time to time during the scan with the bytes done and the total.

    Raises:
        BagError: It is not a bag; or it is damaged before its end (use `recover`, which writes a new one); or
            there is no room for the index.
    """
    if isinstance(path, str) and is_remote(path):
        raise BagError("a URL cannot be written to; `rosproto bag fix` makes a new bag from it", path=path)
    source = BagFile(path, scanning=scanning)
    try:
        found = open_index(source)
    finally:
        source.close()
    if found.closed and not found.damage:
        with BagReader(path) as bag:
            _refuse(bag.index_damage(), path)
        return Report(sum(sum(c.counts.values()) for c in found.chunks), ())
    whole = _whole_chunks(found, path)
    rest, compression = _messages_after(path, found, len(whole))
    end = found.chunks[len(whole)].pos if len(whole) < len(found.chunks) else found.end
    used = {number for chunk in whole for number in chunk.counts}
    connections = {number: found.connections[number] for number in sorted(used)}
    with _kept_on_failure(path, found.head, end):
        _write_contents(path, BagIndex(connections, whole, end, head=found.head))
        with BagWriter(path, compression, append=True) as writer:
            for topic, message, time in rest:
                writer.write(topic, message, time)
    with BagReader(path) as bag:
        return Report(bag.message_count, tuple(found.damage))


def _whole_chunks(found: BagIndex, path: File) -> list[ChunkInfo]:
    """The complete, indexed chunks; all of them must come before any other chunk."""
    whole = [chunk for chunk in found.chunks if chunk.indexed and not chunk.partial]
    if found.resumed or whole != found.chunks[: len(whole)]:
        _refuse(found.damage, path)
    return whole


def _refuse(damage: list[str], path: File) -> None:
    """Raise an error if there is damage that an index at the end does not mend."""
    if damage:
        text = "damaged before its end ({why}); `rosproto bag fix` writes what can be read into a new bag"
        raise BagError(say(text, why="; ".join(damage)), path=_name(path))


def _messages_after(
    path: File, found: BagIndex, count: int
) -> tuple[list[tuple[str, RawMessage, Time]], Literal["none", "bz2", "lz4"]]:
    """Readable messages after the first `count` chunks, from the unfinished one, and its compression."""
    if len(found.chunks) <= count:
        return [], "none"
    with _TailReader(path, found, count) as bag:
        kinds = bag.compression()
        return list(bag.read_messages(raw=True)), next(kind for kind in COMPRESSIONS if kind in kinds)


class _TailReader(BagReader):
    """A reader of the chunks from `count` on; it uses the results of a scan to avoid a second one."""

    def __init__(self, path: File, found: BagIndex, count: int) -> None:
        self._source = BagFile(path)
        self._skip, self._lost = True, found.lost
        self._spans = found.spans()
        self._take_contents(found.connections, found.chunks[count:], list(found.damage))
        self.version, self.indexed = found.version, found.closed


@contextmanager
def _kept_on_failure(path: File, begin: int, end: int) -> Iterator[None]:
    """If the repair fails, restore the file header and all bytes from `end` on: there is no other copy."""
    with _opened(path, "rb") as file:
        file.seek(begin)
        header = file.read(len(FileHeader().encode()))
        file.seek(end)
        rest = file.read()
    try:
        yield
    except BaseException as problem:
        # The disk had room for these bytes before. If writing fails now, nothing was changed before either.
        with suppress(OSError), _opened(path, "r+b") as file:
            file.truncate(end)
            file.seek(end)
            file.write(rest)
            file.seek(begin)
            file.write(header)
        why = problem if isinstance(problem, OSError) else problem.__cause__
        if isinstance(why, OSError):
            text = "cannot repair the bag: {why}; it is left as it was; make room, or repair a copy"
            raise BagError(say(text, why=why.strerror), path=_name(path)) from problem
        raise


def _write_contents(path: File, index: BagIndex) -> None:
    """Truncate the file after the chunks and write the table of contents."""
    header = FileHeader(index.end, len(index.connections), len(index.chunks))
    with _opened(path, "r+b") as file:
        file.truncate(index.end)
        file.seek(index.end)
        file.write(encode_contents(index.connections.values(), index.chunks))
        file.seek(index.head)
        file.write(header.encode())


@contextmanager
def _opened(path: File, mode: Literal["rb", "r+b"]) -> Iterator[BinaryIO]:
    """Open a path and close it afterwards; a file object is used unchanged and stays open."""
    if isinstance(path, (str, os.PathLike)):
        with open(path, mode) as file:
            yield file
    else:
        yield path


def _name(path: File) -> str | None:
    return os.fspath(path) if isinstance(path, (str, os.PathLike)) else None


def recover(
    path: Path,
    output: Path,
    *,
    compression: Literal["none", "bz2", "lz4", "zstd"] = "none",
    progress: Callable[[int], None] | None = None,
    found: Callable[[int], None] | None = None,
    scanning: Scanning | None = None,
) -> Report:
    """Write every message that can still be read into a new bag.

    Args:
        path: The damaged bag, or a URL of one; it is not changed.
        output: The new bag; must not exist.
        compression: Of the new bag; see `create_bag`.
        progress: Called regularly with the number of messages.
        found: Called once with the number of messages in the index or scan; not all may be readable.
        scanning: Called from time to time during a scan with the bytes done and the total.

    Raises:
        BagError: `path` is not a bag, or `output` exists or cannot be written.
    """
    if os.path.exists(output):
        raise BagError("already exists; choose another name", path=os.fspath(output))
    with (
        open_bag(path, skip_damaged=True, scanning=scanning) as bag,
        create_bag(output, compression) as writer,
    ):
        if found is not None:
            found(bag.message_count)
        for topic, message, time in bag.read_messages(raw=True):
            writer.write(topic, message, time)
            if progress is not None and writer.message_count % 100 == 0:
                progress(writer.message_count)
        return Report(writer.message_count, tuple(bag.damage))
