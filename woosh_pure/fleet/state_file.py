"""What has to survive a vehicle's process: one JSON file for each vehicle, always replaced as a whole.

Two processes that kept their orders in one file would restore each other's. So a vehicle that is open holds a
lock on a file beside it; the system takes the lock back when its process ends, however it ends.
"""

from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path
from typing import Any

from rosproto.files import replace_file
from rosproto.logs import get_logger
from woosh_pure.errors import ChassisError

_log = get_logger("woosh_pure.fleet.state_file")
_WRITE = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)

_LOCK = os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0)

if sys.platform == "win32":
    import msvcrt

    def _lock_file(opened: int) -> None:
        msvcrt.locking(opened, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock_file(opened: int) -> None:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)


def default_folder() -> Path:
    """Where the states of this user's vehicles are: `$XDG_STATE_HOME/woosh/fleet`, on Windows
    `%LOCALAPPDATA%`."""
    given = os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA")
    return (Path(given) if given else Path.home() / ".local" / "state") / "woosh" / "fleet"


class StoreInUse(ChassisError, OSError):
    """Another vehicle, of this process or another one, keeps its order in this file."""


class Store:
    """The file of one vehicle. After `save` has returned, neither kill -9 nor a loss of power takes it back.

    Args:
        folder: Where it is; made when it is not there.
        manufacturer, serial: Of the vehicle.
    """

    def __init__(self, folder: Path, manufacturer: str, serial: str) -> None:
        name = re.sub(r"[^A-Za-z0-9_.-]", "_", f"{manufacturer}-{serial}")
        self.path = folder / f"{name}.json"
        self._file, self._folder = str(self.path), str(folder)
        self._beside = str(self.path.with_suffix(".new"))
        self._last = ""
        self._locked: int | None = None  # the open lock file
        self._to_lock = False

    def __str__(self) -> str:
        return str(self.path)

    def lock(self) -> None:
        """Keep others from using it until `unlock`.

        Raises:
            StoreInUse: Somebody does already.
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
        """Let others use it."""
        self._to_lock = False
        if self._locked is not None:
            os.close(self._locked)
            self._locked = None

    def _in_use(self) -> str:
        return (
            f"the order kept in {self.path} belongs to a vehicle that is running already; end that one, or "
            "give this one a serial number or a folder (--state) of its own"
        )

    def load(self) -> dict[str, Any] | None:
        """What was saved last; None where nothing was. What cannot be read is put aside, and the log
        tells."""
        try:
            text = self.path.read_text("utf-8")
        except FileNotFoundError:
            return None
        try:
            found = json.loads(text)
        except ValueError:
            self.put_aside("it is no JSON")
            return None
        return found if isinstance(found, dict) else None

    def put_aside(self, why: str) -> None:
        """Move an unusable file aside, under another name."""
        aside = self.path.with_suffix(".broken")
        _log.warning("! %s cannot be used (%s); it is kept as %s", self.path, why, aside)
        replace_file(self.path, aside)

    def save(self, data: dict[str, Any]) -> None:
        """Replace the file if its content differs.

        Raises:
            OSError: The disk is full, or the folder cannot be written.
        """
        if self._to_lock:
            self.lock()
        text = json.dumps(data, separators=(",", ":"))
        if text == self._last:
            return
        encoded = text.encode()
        try:
            self._replace(encoded)
        except FileNotFoundError:  # the folder is not there yet, or not any more
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._replace(encoded)
        self._last = text

    def _replace(self, data: bytes) -> None:
        """Write it beside, and give it the name. Each node that is passed costs one of these: so no objects
        for paths and files, which took half of the time of the processor."""
        opened = os.open(self._beside, _WRITE, 0o666)
        try:
            written = 0
            while written < len(data):
                written += os.write(opened, data[written:] if written else data)
            os.fsync(opened)
        finally:
            os.close(opened)
        replace_file(self._beside, self._file)
        if os.name == "posix":  # have the new name on disk, too; Windows has no such call
            folder = os.open(self._folder, os.O_RDONLY)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)
