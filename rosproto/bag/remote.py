"""Remote bags: any URL that fsspec opens (`s3://`, `https://`), read by byte ranges.

Needs fsspec (the extra `remote`) and its package for the URL's scheme, such as aiohttp or s3fs.
"""

from __future__ import annotations

import errno
import io
import os
from typing import TYPE_CHECKING, BinaryIO, cast

from rosproto.errors import BagError
from rosproto.extras import optional_module

if TYPE_CHECKING:
    from fsspec import AbstractFileSystem
    from fsspec.spec import AbstractBufferedFile

AHEAD = 32 << 10
"""Minimum bytes per request: the head of a chunk and the beginning of its data."""
_ENDINGS = (".bag", ".mcap")
_CREDENTIALS = (
    "; it wants credentials, or others: they are taken from where the package for that scheme looks for them,"
    " in the environment and in its configuration"
)
_NO_RANGES = "its server gives no ranges of it, and a bag is read by position; download it first"


def is_remote(path: str) -> bool:
    """Whether the path is a URL."""
    return "://" in path


def open_remote(url: str) -> BinaryIO:
    """A seekable file that fetches the bytes to be read and at most `AHEAD` more.

    Raises:
        BagError: It cannot be opened, its server has no range requests, or fsspec is missing (extra
            `remote`).
    """
    filesystem, path = _filesystem(url)
    try:
        # fsspec's own read-ahead is off: it would fetch megabytes around every record head.
        file = filesystem.open(path, "rb", cache_type="none")
        size = file.seek(0, io.SEEK_END) if file.seekable() else None
    except Exception as problem:  # file systems raise their own errors
        raise BagError(f"it cannot be opened: {_why(problem)}", path=url) from problem
    if size is None:
        file.close()
        raise BagError(_NO_RANGES, path=url)
    return cast(BinaryIO, _RangeFile(file, url, size))


def remote_files(url: str) -> list[str]:
    """The recordings at a URL: all bags and MCAP files in a folder, or all that match a pattern.

    Raises:
        BagError: The URL cannot be reached, or fsspec is missing.
    """
    filesystem, path = _filesystem(url)
    try:
        if any(sign in path for sign in "*["):
            found = filesystem.glob(path)
        elif path.lower().endswith(_ENDINGS):
            return [url]
        elif filesystem.isdir(path):
            found = [name for name in filesystem.find(path) if name.lower().endswith(_ENDINGS)]
        else:
            return [url]
    except Exception as problem:
        raise BagError(f"the folder cannot be listed: {_why(problem)}", path=url) from problem
    return sorted(filesystem.unstrip_protocol(name) for name in found)


def _filesystem(url: str) -> tuple[AbstractFileSystem, str]:
    missing = BagError('bags behind a URL need the package fsspec: pip install ".[remote]"', path=url)
    fsspec = optional_module("fsspec", missing)
    try:
        filesystem, path = fsspec.core.url_to_fs(url)
    except (ValueError, ImportError) as problem:
        raise BagError(f"fsspec cannot reach it: {problem}", path=url) from problem
    return filesystem, path


def _why(problem: BaseException) -> str:
    """The reason for a failure, as text; fsspec reports nearly every failure as a missing file."""
    chain = [problem]
    while (deeper := chain[-1].__cause__ or chain[-1].__context__) is not None and deeper not in chain:
        chain.append(deeper)
    for each in chain:
        status = getattr(each, "status", None)
        if isinstance(status, int) and status >= 400:
            from http.client import responses  # imported here: it loads ssl

            text = f"the server answers {status} {responses.get(status, '')}".rstrip()
            return text + _CREDENTIALS if status in (401, 403) else text
    root = chain[-1]
    if isinstance(root, PermissionError) or "Credentials" in type(root).__name__:
        return _said(root) + _CREDENTIALS
    if "range requests" in str(root):
        return _NO_RANGES
    if isinstance(root, FileNotFoundError):
        return "there is no such file"
    if isinstance(root, OSError) and root.errno:
        # asyncio's own text ("Connect call failed") is less specific.
        return os.strerror(root.errno) if root.errno > 0 else str(root.strerror)
    return _said(root)


def _said(problem: BaseException) -> str:
    return f"{type(problem).__name__}: {problem}" if str(problem) else type(problem).__name__


class _RangeFile(io.RawIOBase):
    """Fetches the requested bytes and the beginning of the probable next read.

    Attributes:
        far: True: each read takes a round trip, so few large reads are better than many exact ones.
        name: The URL.
    """

    far = True

    def __init__(self, file: AbstractBufferedFile, url: str, size: int) -> None:
        self._file = file
        self.name = url
        self._size = size
        self._at = 0
        self._held, self._held_at = b"", 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self._at = {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._size}[whence] + offset
        return self._at

    def tell(self) -> int:
        return self._at

    def read(self, size: int | None = -1) -> bytes:
        left = max(0, self._size - self._at)
        count = left if size is None or size < 0 else min(size, left)
        first = self._at - self._held_at
        begin = self._held[first : first + count] if 0 <= first < len(self._held) else b""
        missing = count - len(begin)
        if missing:
            at = self._at + len(begin)
            fresh = self._fetch(at, min(max(missing, AHEAD), self._size - at))
            if missing < AHEAD:
                self._held, self._held_at = fresh, at
            begin += fresh[:missing]
        self._at += count
        return begin

    def _fetch(self, at: int, count: int) -> bytes:
        try:
            self._file.seek(at)
            data = bytes(self._file.read(count))
        except Exception as problem:
            raise OSError(errno.EIO, f"{_why(problem)}") from problem
        if len(data) != count:
            raise OSError(errno.EIO, f"its server gave {len(data)} bytes where {count} were asked for")
        return data

    def close(self) -> None:
        if not self.closed:
            self._file.close()
        super().close()
