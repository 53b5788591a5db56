"""How much a bag may ask of whoever reads it.

bz2 packs a gigabyte of zeros into a kilobyte, so the size of a file says nothing about the memory and the
time it takes to read. What a file's compressed chunks become together is therefore measured against the file,
by what their headers declare, before any of them is unpacked; and no chunk ever gives more than it declared.
The records in them are counted too: each costs far more than its bytes.
"""

from __future__ import annotations

import threading

from rosproto.records import NamedTuple

__all__ = ["MOST_CONNECTIONS", "BagLimits", "Budget"]

MOST_CONNECTIONS = 1 << 16
"""Connection records of one bag, or of one chunk; each becomes an object, however short it is."""


class BagLimits(NamedTuple):
    """Bounds for reading one bag, its file perhaps made to harm; the defaults are far from real recordings.

    Attributes:
        chunk_bytes: One chunk, uncompressed or as stored: a message of roscpp's limit, its records around it.
        expansion: Bytes that compressed chunks may become for each byte of the file. (Recordings of robots
            become 2 to 20 times as large. Black pictures of a simulated camera become a few thousand times.)
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
    """What one file may still ask for: each chunk counts once, with the most it was seen to take.

    Any thread may use it.
    """

    def __init__(self, allowed: int) -> None:
        self.allowed = allowed
        self._taken: dict[int, int] = {}
        self._sum = 0
        self._lock = threading.Lock()

    def room(self, position: int) -> int:
        """What the chunk there may take."""
        with self._lock:
            return self.allowed - self._sum + self._taken.get(position, 0)

    def take(self, position: int, amount: int) -> bool:
        """Whether the chunk there may take so much; then it is counted."""
        with self._lock:
            more = max(0, amount - self._taken.get(position, 0))
            if self._sum + more > self.allowed:
                return False
            self._sum += more
            self._taken[position] = self._taken.get(position, 0) + more
            return True
