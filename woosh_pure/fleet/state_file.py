"""What a vehicle keeps on disk: `Store` is the file of its order, with a lock; `Journal` has its reports.

The order's file is JSON and always replaced as a whole. An open vehicle locks a file beside it, so that two
processes cannot restore each other's orders; the system releases the lock when the process ends for any
reason.
"""

from __future__ import annotations

import json
import os
import re
import sys
import threading
import time
from collections import deque
from collections.abc import Mapping
from pathlib import Path

from rosproto.files import replace_file, save_file
from rosproto.logs import get_logger
from rosproto.text import printable
from woosh_pure.errors import ChassisError
from woosh_pure.fleet.messages.parsing import timestamp

_log = get_logger("woosh_pure.fleet.state_file")
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
    """The default folder: `$XDG_STATE_HOME/woosh/fleet`, on Windows in `%LOCALAPPDATA%`."""
    given = os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA")
    return (Path(given) if given else Path.home() / ".local" / "state") / "woosh" / "fleet"


class StoreInUse(ChassisError, OSError):
    """Another vehicle, of this or another process, uses the file."""


class Store:
    """The file of one vehicle. What `save` has written survives kill -9 and a loss of power.

    Args:
        folder: The file's folder; created if it does not exist.
        manufacturer, serial: The vehicle.
    """

    def __init__(self, folder: Path, manufacturer: str, serial: str) -> None:
        name = re.sub(r"[^A-Za-z0-9_.-]", "_", f"{manufacturer}-{serial}")
        self.path = folder / f"{name}.json"
        self._last = ""
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
        return (
            f"the order kept in {self.path} belongs to a vehicle that is running already; end that one, or "
            "give this one a serial number or a folder (--state) of its own"
        )

    def load(self) -> dict[str, object] | None:
        """Return the saved data; None if there is none. An unreadable file is renamed and logged."""
        try:
            text = self.path.read_text("utf-8")
        except FileNotFoundError:
            return None
        try:
            found = json.loads(text)
        except ValueError:
            self.put_aside("it is not JSON")
            return None
        return found if isinstance(found, dict) else None

    def put_aside(self, why: str) -> None:
        """Rename an unusable file."""
        aside = self.path.with_suffix(".broken")
        _log.warning("! %s cannot be used (%s); it is kept as %s", self.path, why, aside)
        replace_file(self.path, aside)

    def save(self, data: Mapping[str, object]) -> None:
        """Replace the file if its content differs.

        Raises:
            OSError: The disk is full, or the folder cannot be written.
        """
        if self._to_lock:
            self.lock()
        text = json.dumps(data, separators=(",", ":"))
        if text == self._last:
            return
        save_file(self.path, text.encode(), durable=True)
        self._last = text


# -- the reports of logReport --------------------------------------------------------------------------------

MAX_LINES = 500
MAX_REPORTS = 50
"""Number of reports that are kept; the oldest is deleted, so that the disk does not fill."""


class Journal:
    """The recent events of one vehicle, and its reports.

    Args:
        folder: Folder of the reports; created with the first one.
        name: Start of their names.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.folder, self.name = folder, name
        self._lines: deque[str] = deque(maxlen=MAX_LINES)
        self._lock = threading.Lock()

    def note(self, text: str) -> None:
        """Record an event with the time."""
        line = f"{timestamp(time.time())} {printable(text)[:500]}"
        with self._lock:
            self._lines.append(line)

    def write(self, reason: str, facts: Mapping[str, object]) -> str:
        """Store a report and return its name.

        Raises:
            OSError: The file cannot be written.
        """
        with self._lock:
            lines = list(self._lines)
        moment = timestamp(time.time()).replace(":", "").replace(".", "")
        path = self.folder / f"{self.name}-{moment}.json"
        text = json.dumps({"reason": reason, **facts, "lately": lines}, indent=1, ensure_ascii=False)
        save_file(path, text.encode())
        for old in sorted(self.folder.glob(f"{self.name}-*.json"))[:-MAX_REPORTS]:
            old.unlink(missing_ok=True)
        return path.name
