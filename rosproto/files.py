"""Read and write small files that the user named, with a limit on the size read.

A name may lead to a device or pipe without an end (`/dev/zero`, `/dev/full`); an unlimited `read()` would
take all memory.
"""

from __future__ import annotations

import os
import sys
import time
from typing import TextIO

from rosproto.sentence import say

__all__ = [
    "MAX_FILE_BYTES", "read_file", "read_stream", "read_text", "replace_file", "save_file", "write_file",
]  # fmt: skip

MAX_FILE_BYTES = 64 << 20
"""Default limit of a file that is read whole."""


def read_file(path: str | os.PathLike[str], limit: int = MAX_FILE_BYTES) -> bytes:
    """Read a whole file.

    Raises:
        OSError: It cannot be read.
        ValueError: It has more than `limit` bytes, or does not end.
    """
    with open(path, "rb") as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        text = "{path}: more than {limit} bytes; is this the right file?"
        raise ValueError(say(text, path=os.fspath(path), limit=limit))
    return data


def read_text(path: str | os.PathLike[str], encoding: str = "utf-8", limit: int = MAX_FILE_BYTES) -> str:
    """Read a whole text file; line ends become `\\n`.

    Raises:
        OSError: It cannot be read.
        ValueError: It has more than `limit` bytes, does not end, or is not text.
    """
    text = read_file(path, limit).decode(encoding)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_stream(stream: TextIO, name: str, limit: int = MAX_FILE_BYTES) -> str:
    """Read a whole text stream, such as stdin.

    Raises:
        ValueError: It has more than `limit` characters, or does not end.
    """
    text = stream.read(limit + 1)
    if len(text) > limit:
        wrong = "{name}: more than {limit} characters; is this the right input?"
        raise ValueError(say(wrong, name=name, limit=limit))
    return text


def write_file(path: str | os.PathLike[str], data: bytes, *, durable: bool = False) -> None:
    """Write a file, replacing an existing one; a `durable` one is on the disk when this returns.

    Raises:
        OSError: It cannot be written. The error names the file, which Python's own does not when the disk is
            full.
    """
    try:
        with open(path, "wb") as file:
            file.write(data)
            if durable:
                file.flush()
                os.fsync(file.fileno())
    except OSError as error:
        raise OSError(error.errno, error.strerror, os.fspath(path)) from error


def save_file(path: str | os.PathLike[str], data: bytes, *, durable: bool = False) -> None:
    """Write a file as a whole, in its folder, which is made: an interrupted write leaves the old one.

    Args:
        path: The file; `path` with `.new` behind is used on the way.
        data: Its content.
        durable: Whether it survives a loss of power once this returns, which takes a moment longer.

    Raises:
        OSError: It cannot be written.
    """
    folder, beside = os.path.dirname(os.path.abspath(path)), f"{os.fspath(path)}.new"
    os.makedirs(folder, exist_ok=True)
    write_file(beside, data, durable=durable)
    replace_file(beside, path)
    if durable and os.name == "posix":  # the new name, too; Windows has no such call
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


_PAUSES = (0.01, 0.02, 0.05, 0.1, 0.2)


def replace_file(source: str | os.PathLike[str], target: str | os.PathLike[str]) -> None:
    """Rename a file to `target`, in place of what is there (`os.replace`).

    Windows refuses while another process has either file open: a virus scanner, an indexer, a reader of the
    target. They take milliseconds, so it is tried again for 0.4 s there.

    Raises:
        OSError: It cannot be renamed.
    """
    for pause in _PAUSES if sys.platform == "win32" else ():
        try:
            os.replace(source, target)
            return
        except PermissionError:
            time.sleep(pause)
    os.replace(source, target)
