"""Bags recorded through the web: one at a time for each robot, limited in time and size."""

from __future__ import annotations

import errno
import itertools
import os
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from rosproto.errors import BagError, RosError
from rosproto.logs import get_logger
from rosproto.recording import Recorder
from rosproto.sentence import say
from woosh_pure.chassis import Chassis
from woosh_pure.interface.recorded_topics import selection_of
from woosh_pure.web.http_errors import Problem

MAX_SECONDS, MAX_BYTES, MIN_FREE_BYTES, MAX_KEPT = 3600.0, 1 << 30, 1 << 29, 20
NOT_WRITTEN = say("the bag cannot be written; the log of the server says why")
"""Answers do not contain paths of this computer."""
NO_ROOM = say("the disk of the server is nearly full; the bag holds what came until then")
End = Literal["", "asked", "limit", "no-room", "not-written"]
"""Why a recording ended: "" while it runs; somebody asked; its longest time or largest size was reached; the
disk is nearly full; the bag cannot be written."""
_logger = get_logger("woosh_pure.web")


def require_folder(folder: Path) -> Path:
    """Return a writable folder for bags, checked at the start and not at the first recording.

    Raises:
        ValueError: There is no such folder, or nothing can be written there.
    """
    if not folder.is_dir():
        raise ValueError(
            say("recordings: there is no folder {folder}; create it, or give another", folder=folder)
        )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ValueError(say("recordings: cannot write to {folder}; change its permissions", folder=folder))
    return folder


@dataclass(slots=True)
class Recording:
    """One bag.

    Attributes:
        id: Its number, as text.
        who: The name of the client that started it.
        recorder: The recorder that writes it.
        path: Where the bag is once it is finished.
        begun: When it was started, s since 1970.
        asked: Whether somebody has ended it.
        logged: Whether the log has the error that ended it.
    """

    id: str
    who: str
    recorder: Recorder
    path: Path
    begun: float
    asked: bool = False
    logged: bool = False

    @property
    def running(self) -> bool:
        """Whether it is still being recorded."""
        return not self.recorder.finished

    @property
    def end(self) -> End:
        """Why it ended."""
        if self.running:
            return ""
        if self.recorder.error is None:
            return "asked" if self.asked else "limit"
        cause = self.recorder.error.__cause__
        full = isinstance(cause, OSError) and cause.errno in (errno.ENOSPC, errno.EDQUOT)
        return "no-room" if full else "not-written"

    def log_error(self) -> None:
        """Log once what ended it early."""
        error = self.recorder.error
        if error is not None and not self.logged:
            self.logged = True
            _logger.error("! recording %s: %s", self.id, error)

    def as_json(self) -> dict[str, object]:
        """The recording as the API sends it."""
        stats, end = self.recorder.stats(), self.end
        return {
            "id": self.id,
            "who": self.who,
            "name": self.path.name,
            "begun": round(self.begun, 3),
            "running": end == "",
            "end": end,
            "seconds": round(stats.seconds, 1),
            "bytes": stats.bytes,
            "messages": stats.messages,
            "topics": stats.topics,
            "dropped": stats.dropped,
            "error": {"no-room": NO_ROOM, "not-written": NOT_WRITTEN}.get(end, ""),
        }


class RecordingManager:
    """The recordings of one robot. Safe from any thread; everything blocks for a moment.

    Args:
        folder: Where the bags are kept. With None, the first recording creates a temporary folder.

    Attributes:
        folder: As given, or that temporary folder.
    """

    def __init__(self, chassis: Chassis, folder: Path | None = None) -> None:
        self._chassis, self.folder = chassis, folder
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._all: dict[str, Recording] = {}

    def begin(self, who: str, seconds: float | None = None, camera: bool = False) -> Recording:
        """Start to record, for an hour or 1 GiB at most. The oldest bags are deleted when the list is full.

        Raises:
            Problem: A recording runs already, or the bag cannot be written.
        """
        with self._lock:
            for one in self._all.values():
                if one.running:
                    text = "recording {id} of {who} is running; end it first"
                    raise Problem(409, text, "recording", id=one.id, who=one.who)
            for old in list(self._all)[: max(0, len(self._all) - MAX_KEPT + 1)]:
                try:
                    self._all[old].path.unlink(missing_ok=True)
                except OSError as error:  # Windows, during a download; tried again
                    _logger.warning("! the bag of recording %s cannot be deleted: %s", old, error)
                else:
                    del self._all[old]
            if self.folder is None:
                self.folder = Path(tempfile.mkdtemp(prefix="woosh-web-"))
            number = str(next(self._numbers))
            path = self._free(time.strftime("%Y%m%d-%H%M%S"), number)
            try:
                recorder = Recorder(
                    self._chassis.node,
                    path,
                    selection=selection_of(camera=camera),
                    compression="lz4",
                    max_seconds=min(seconds or MAX_SECONDS, MAX_SECONDS),
                    max_bytes=MAX_BYTES,
                    buffer_bytes=64 << 20,
                    min_free_bytes=MIN_FREE_BYTES,
                )
            except BagError as error:
                _logger.error("! a recording cannot begin: %s", error)
                raise Problem(503, NOT_WRITTEN, "bag-error") from error
            self._all[number] = found = Recording(number, who, recorder, path, time.time())
            return found

    def _free(self, stamp: str, number: str) -> Path:
        assert self.folder is not None
        path, more = self.folder / f"woosh-{stamp}-{number}.bag", 1
        while path.exists():
            more += 1
            path = self.folder / f"woosh-{stamp}-{number}-{more}.bag"
        return path

    def end(self, number: str) -> Recording:
        """End the recording; its bag is complete then.

        Raises:
            Problem: There is no recording with that number.
        """
        found = self.get(number)
        found.asked = found.asked or found.running
        try:
            found.recorder.close()
        except RosError:
            pass  # `end` and `error` tell it
        found.log_error()
        return found

    def remove(self, number: str) -> None:
        """End the recording and delete its bag.

        Raises:
            Problem: There is no such recording, or its bag cannot be deleted.
        """
        found = self.end(number)
        try:
            found.path.unlink(missing_ok=True)
        except OSError as error:  # Windows, during a download
            why = say("the bag of recording {id} cannot be deleted: {error}", id=number, error=error.strerror)
            raise Problem(409, why, "recording") from None
        with self._lock:
            self._all.pop(number, None)

    def get(self, number: str) -> Recording:
        """Return the recording with that number.

        Raises:
            Problem: There is no such recording.
        """
        with self._lock:
            found = self._all.get(number)
        if found is None:
            raise Problem(404, "there is no recording {number!r}", number=number[:20])
        return found

    def all(self) -> list[Recording]:
        """Return all recordings, the oldest first."""
        with self._lock:
            found = list(self._all.values())
        for one in found:
            one.log_error()
        return found

    def close(self) -> None:
        """End all recordings; the bags are kept."""
        for one in self.all():
            self.end(one.id)
