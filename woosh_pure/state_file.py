"""`Store`: the state of one robot on disk, with a lock: the order of a vehicle, or its missions.

The file has a JSON object in each line: a whole state, which replaces the file, and each change
since, which is added. So an order is written once, and then its progress. A line is on the disk before its
state is published and before anything of it begins. After a crash or a loss of power

    the file ends within its last line    the state before it is restored: nothing of the last one has begun
    another line is not a JSON object     the order is not known: the file is put aside, with a warning

An open vehicle locks a file beside it, so that two processes cannot restore each other's orders; the system
releases the lock when the process ends for any reason.
"""

from __future__ import annotations

import errno
import json
import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path

from rosproto.files import replace_file, save_file
from rosproto.logs import get_logger
from woosh_pure.errors import ChassisError

_log = get_logger("woosh_pure.state_file")
MIN_CHANGES = 64 << 10
"""Bytes of changes after which the file is replaced, if they are more than the state before them."""
_compact = json.JSONEncoder(separators=(",", ":")).encode
_LOCK = os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0)
_APPEND = os.O_WRONLY | os.O_APPEND | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)

if sys.platform == "win32":
    import msvcrt

    def _lock_file(opened: int) -> None:
        msvcrt.locking(opened, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock_file(opened: int) -> None:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)


def default_folder(name: str = "fleet") -> Path:
    """The default folder: `$XDG_STATE_HOME/woosh/fleet`, on Windows in `%LOCALAPPDATA%`."""
    given = os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA")
    return (Path(given) if given else Path.home() / ".local" / "state") / "woosh" / name


class StoreInUse(ChassisError, OSError):
    """Another vehicle, of this or another process, uses the file."""


class Store:
    """The file of one vehicle. What `save` and `add` have written survives kill -9 and a loss of power.

    Args:
        folder: The file's folder; created if it does not exist.
        manufacturer, serial: The vehicle.
        in_use: The error when another one has locked it; "" for that of a vehicle.
    """

    def __init__(self, folder: Path, manufacturer: str, serial: str, *, in_use: str = "") -> None:
        name = re.sub(r"[^A-Za-z0-9_.-]", "_", f"{manufacturer}-{serial}")
        self.path, self._used = folder / f"{name}.json", in_use
        self._state_bytes = self._file_bytes = 0  # of the file as this object has left it; 0 if it has not
        self._locked: int | None = None  # the open lock file
        self._to_lock = False

    def __str__(self) -> str:
        return str(self.path)

    def lock(self) -> None:
        """Lock the file until `unlock`.

        Raises:
            StoreInUse: Another vehicle has locked it.
            OSError: The disk is full, or the folder cannot be written; `save` tries again.
        """
        if self._locked is not None:
            raise StoreInUse(self._in_use())
        self._to_lock = True
        self.path.parent.mkdir(parents=True, exist_ok=True)
        opened = os.open(self.path.with_suffix(".lock"), _LOCK, 0o666)
        try:
            _lock_file(opened)
        except OSError as error:
            os.close(opened)
            raise StoreInUse(self._in_use()) from error
        self._locked, self._to_lock = opened, False

    def unlock(self) -> None:
        """Release the lock."""
        self._to_lock = False
        if self._locked is not None:
            os.close(self._locked)
            self._locked = None

    def _in_use(self) -> str:
        return self._used or (
            f"the order kept in {self.path} belongs to a vehicle that is running already; end that one, or "
            "give this one a serial number or a folder (--state) of its own"
        )

    def load(self) -> list[dict[str, object]]:
        """Return the saved state and the changes since; nothing if there is none. An unreadable file is
        renamed and logged."""
        try:
            lines = self.path.read_bytes().splitlines(keepends=True) or [b""]
        except FileNotFoundError:
            return []
        found: list[dict[str, object]] = []
        for number, line in enumerate(lines, 1):
            try:
                found.append(dict(json.loads(line)))
            except (ValueError, TypeError):
                if number == 1 or line.endswith(b"\n"):
                    self.put_aside(f"line {number} is not a JSON object")
                    return []
                _log.info("= %s: the last change was not written to its end, and is left out", self.path)
        return found

    def put_aside(self, why: str) -> None:
        """Rename an unusable file."""
        aside = self.path.with_suffix(".broken")
        _log.warning("! %s cannot be used (%s); it is kept as %s", self.path, why, aside)
        replace_file(self.path, aside)

    def save(self, data: Mapping[str, object]) -> None:
        """Replace the file by a state.

        Raises:
            OSError: The disk is full, or the folder cannot be written.
        """
        if self._to_lock:
            self.lock()
        self._state_bytes = self._file_bytes = 0
        line = _line(data)
        save_file(self.path, line, durable=True)
        self._state_bytes = self._file_bytes = len(line)

    def add(self, change: Mapping[str, object]) -> bool:
        """Add a change to the file, if there is one. False if a state is to be saved instead: there are many
        changes, or the file is not as this object has left it.

        Raises:
            OSError: The disk is full, or the file cannot be written.
        """
        size, self._file_bytes = self._file_bytes, 0  # also if it fails: part of the line may be written
        line = _line(change) if change else b""
        if not size or size + len(line) > self._state_bytes + max(self._state_bytes, MIN_CHANGES):
            return False
        if line and not self._append(line, size):
            return False
        self._file_bytes = size + len(line)
        return True

    def _append(self, line: bytes, size: int) -> bool:
        """Add a line to the file; False if that has not this size."""
        try:
            opened = os.open(self.path, _APPEND)
        except FileNotFoundError:
            return False
        try:
            if os.fstat(opened).st_size != size:
                return False
            if os.write(opened, line) != len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self.path))
            os.fsync(opened)
        finally:
            os.close(opened)
        return True


def _line(data: Mapping[str, object]) -> bytes:
    return _compact(data).encode() + b"\n"
