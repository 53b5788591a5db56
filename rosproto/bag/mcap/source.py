"""The stream the library reads from: it never returns, nor allocates, more bytes than the file has."""

from __future__ import annotations

import os

from rosproto.bag.bag_file import BagFile

__all__ = ["SafeStream"]


class SafeStream:
    """A stream over a `BagFile`.

    Args:
        source: The file.
        begin: Position of its first byte.
    """

    def __init__(self, source: BagFile, begin: int = 0) -> None:
        self._source = source
        self._at = begin

    def read(self, size: int = -1) -> bytes:
        left = max(0, self._source.size - self._at)
        data = self._source.read_at(self._at, left if size < 0 else min(size, left))
        self._at += len(data)
        return data

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._source.size}[whence]
        if base + offset < 0:
            raise ValueError(f"a position {base + offset} before the beginning of the file")
        self._at = base + offset
        return self._at

    def tell(self) -> int:
        return self._at

    def seekable(self) -> bool:
        return True
