"""`Journal`: the recent events of a vehicle, and the reports of logReport."""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from collections.abc import Mapping
from pathlib import Path

from rosproto.files import save_file
from rosproto.text import printable
from woosh_pure.fleet.messages.parsing import timestamp

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
