"""How much memory and time a bag may cost its reader.

bz2 packs a gigabyte of zeros into a kilobyte, so the size of a file says nothing about what it takes to read
it. The sizes that the headers of compressed chunks declare are therefore summed up and compared with the size
of the file before any chunk is decompressed, and no chunk ever yields more than it declared. The records in
them are counted as well, because each costs far more than its bytes.
"""

from __future__ import annotations

import threading

from rosproto.records import NamedTuple

__all__ = ["MOST_CONNECTIONS", "BagLimits", "Budget"]

MOST_CONNECTIONS = 1 << 16
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
    """What one file may still take: each chunk counts once, with the most it was seen to take.

    Any thread may use it.
    """

    def __init__(self, allowed: int) -> None:
        self.allowed = allowed
        self._taken: dict[int, int] = {}
        self._sum = 0
        self._lock = threading.Lock()

    def room(self, position: int) -> int:
        """How much the chunk at that position may take."""
        with self._lock:
            return self.allowed - self._sum + self._taken.get(position, 0)

    def take(self, position: int, amount: int) -> bool:
        """Whether the chunk at that position may take this much; if so, it is counted."""
        with self._lock:
            more = max(0, amount - self._taken.get(position, 0))
            if self._sum + more > self.allowed:
                return False
            self._sum += more
            self._taken[position] = self._taken.get(position, 0) + more
            return True
