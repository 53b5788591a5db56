"""The input file of a bag reader: reads by position, and limits on memory and records."""

from __future__ import annotations

import errno
import os
import stat
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import BinaryIO, NamedTuple

from rosproto.bag.remote import is_remote, open_remote
from rosproto.errors import BagError, RosError
from rosproto.sentence import say

# -- limits -------------------------------------------------------------------------------------------------
# Limits on the memory and time for reading a bag.
#
# bz2 packs a gigabyte of zeros into a kilobyte, so the size of a file says nothing about what it takes to
# read it. The sizes that the headers of compressed chunks declare are therefore summed up and compared
# with the size of the file before any chunk is decompressed, and no chunk ever yields more than it
# declared. The records in them are counted as well, because each costs far more than its bytes.


MAX_CONNECTIONS = 1 << 16
"""Connection records of one bag, or of one chunk; each becomes an object, however short it is."""


class BagLimits(NamedTuple):
    """Bounds for reading one bag, which may be malicious; real recordings stay far below the defaults.

    Attributes:
        chunk_bytes: One chunk, uncompressed or as stored: the largest message roscpp allows, and its records.
        expansion: Bytes that compressed chunks may expand to for each byte of the file. (Recordings of robots
            grow by a factor of 2 to 20, black pictures of a simulated camera by a few thousand.)
        expansion_spare: Bytes on top of that, so that small bags of anything can be read.
        records: Records in compressed chunks for each byte of the file. (A message's stamp alone takes some.)
        records_spare: Records on top of that.
    """

    chunk_bytes: int = 1_100_000_000
    expansion: int = 5000
    expansion_spare: int = 1 << 26
    records: int = 1
    records_spare: int = 1 << 17


class Budget:
    """The rest of one file's budget. Each chunk counts once, with its largest amount.

    Any thread may use it.
    """

    def __init__(self, allowed: int) -> None:
        self.allowed = allowed
        self._taken: dict[int, int] = {}
        self._sum = 0
        self._lock = threading.Lock()

    def room(self, position: int) -> int:
        """Return how much the chunk at `position` may take."""
        with self._lock:
            return self.allowed - self._sum + self._taken.get(position, 0)

    def take(self, position: int, amount: int) -> bool:
        """Count `amount` for the chunk at `position`; False if it exceeds the budget."""
        with self._lock:
            more = max(0, amount - self._taken.get(position, 0))
            if self._sum + more > self.allowed:
                return False
            self._sum += more
            self._taken[position] = self._taken.get(position, 0) + more
            return True


# -- the file -----------------------------------------------------------------------------------------------


Scanning = Callable[[int, int], None]
"""Called now and then while a file is searched for what it holds: bytes done, and of how many."""


@contextmanager
def system_errors(path: str | None) -> Iterator[None]:
    """Convert errors of the operating system to BagError, with the cause chained.

    ImportError is included: numpy, lz4 and the codec are imported on first use, and an import fails when the
    process has no free file descriptor.

    Raises:
        BagError: In place of an OSError or ImportError.
    """
    try:
        yield
    except RosError:
        raise
    except (OSError, ImportError) as problem:
        code = getattr(problem, "errno", None)
        what = getattr(problem, "strerror", None) or str(problem)
        advice = (
            "; close some, or allow more with `ulimit -n 4096`"
            if code in (errno.EMFILE, errno.ENFILE)
            else ""
        )
        name = getattr(problem, "filename", None) or getattr(problem, "path", None) or "a file"
        raise BagError(f"{name} cannot be opened: {what}{advice}", path=path) from problem


class Unreachable(BagError):
    """The network or the server of a remote file failed. This is not damage; no data is skipped for it."""


class BagFile:
    """A seekable file, read by position.

    Args:
        file: Path, URL (see `remote`), or a seekable binary file (which stays open when this is closed).
        limits: Bounds on the memory its chunks may take.
        scanning: Called by `scanned`.

    Raises:
        BagError: The file cannot be opened, or cannot seek.

    Attributes:
        path: The path, None for a file object without a name.
        size: Length in bytes when opened.
        limits: See above.
        records: Counts the records of compressed chunks against the limit.
        far: True when each read costs a round trip, so that a chunk is best read whole.
    """

    def __init__(
        self,
        file: str | os.PathLike[str] | BinaryIO,
        limits: BagLimits | None = None,
        scanning: Scanning | None = None,
    ) -> None:
        self._scanning = scanning
        self._searching = True
        self._failure: Unreachable | None = None
        self.path: str | None
        self._file: BinaryIO
        self._lock = threading.Lock()
        self.limits = limits or BagLimits()
        if isinstance(file, str) and is_remote(file):
            self.path = file
            self._file = open_remote(file)
            self._owned = True
        elif isinstance(file, (str, os.PathLike)):
            self.path = os.fspath(file)
            try:
                if stat.S_ISFIFO(os.stat(file).st_mode):  # open() would wait for a writer
                    raise BagError(
                        "this is a pipe, and a bag needs random access; save it as a file", path=self.path
                    )
                # Unbuffered: chunks are read whole, a buffer would only copy them once more.
                self._file = open(file, "rb", buffering=0)  # noqa: SIM115
            except OSError as problem:
                text = say("cannot open the bag: {why}", why=problem.strerror)
                raise BagError(text, path=self.path) from problem
            self._owned = True
        else:
            name = getattr(file, "name", None)
            self.path = name if isinstance(name, str) else None
            self._file = file
            self._owned = False
        self.far: bool = getattr(self._file, "far", False) is True
        try:
            self.size = self._file.seek(0, os.SEEK_END)
            if not isinstance(self._file.read(0), bytes):
                raise BagError('the file is opened as text; open it with "rb"', path=self.path)
        except (OSError, ValueError) as problem:
            raise BagError(
                "a bag needs random access, but this file cannot seek or cannot be read", path=self.path
            ) from problem

        asked = self.limits
        self._unpacked = Budget(asked.expansion_spare + asked.expansion * self.size)
        self.records = Budget(asked.records_spare + asked.records * self.size)

    def read_at(self, position: int, count: int) -> bytes:
        """`count` bytes from `position`; fewer where the file ends (or has become shorter).

        Any thread may call it.

        Raises:
            Unreachable: The network or the server behind it fails.
            BagError: The disk fails.
        """
        if self._failure is not None and self._searching:
            raise self._failure
        count = min(count, self.size - position)
        if count <= 0:
            return b""
        try:
            return self._read(position, count)
        except OSError as problem:
            text = f"{count} bytes cannot be read: {problem.strerror}"
            if self.far:
                self._failure = Unreachable(text, path=self.path, offset=position)
                raise self._failure from problem
            raise self.error(text, position) from problem

    def _read(self, position: int, count: int) -> bytes:
        with self._lock:  # or another thread could move the position, or close the file, in between
            self._file.seek(position)
            data = self._file.read(count)
            if len(data) == count:
                return data
            parts = [data]  # a raw file may give less than asked (Linux: at most 2 GiB in one call)
            left = count - len(data)
            while data and left > 0:
                data = self._file.read(left)
                parts.append(data)
                left -= len(data)
        return b"".join(parts)

    def scanned(self, position: int) -> None:
        """Report that a scan has reached `position`."""
        if self._scanning is not None:
            self._scanning(min(position, self.size), self.size)

    def searched(self) -> None:
        """End a scan of the file.

        A scan treats an unreadable record as damaged and continues after it. After a network failure, the
        rest of the file would look damaged; this method raises an error instead.

        Raises:
            Unreachable: The network failed during the scan, so the result is incomplete.
        """
        self._searching = False
        if self._failure is not None:
            raise self._failure

    def allow_unpacking(self, position: int, size: int) -> None:
        """Count a compressed chunk, by its declared size, before it is decompressed. Any thread may call it.

        Raises:
            BagError: Together the file's chunks expand to more than `BagLimits` allow.
        """
        if not self._unpacked.take(position, size):
            raise self.error(
                f"a chunk of {size} bytes, compressed: together more than {self._unpacked.allowed} bytes "
                f"come out of this file of {self.size} bytes; it is damaged or made to fill the memory, "
                "or raise BagLimits.expansion",
                position,
            )

    def check_open(self) -> None:
        """Check that the file is still open.

        Raises:
            BagError: It has been closed.
        """
        if self._owned and self._file.closed:
            raise self.error("the bag is closed")

    def error(self, message: str, offset: int | None = None) -> BagError:
        """A BagError about this file."""
        return BagError(message, path=self.path, offset=offset)

    def close(self) -> None:
        """Close the file if it was opened here."""
        if self._owned:
            with self._lock:
                self._file.close()
