"""Loggers whose records are one printable line each, and `PeerLog`, which limits what peers can have logged.

Peers decide how often an event happens and how long its text is; neither may fill a disk.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from rosproto.bounded_cache import BoundedCache
from rosproto.text import printable

__all__ = ["PeerLog", "cut", "get_logger"]

MAX_CHARACTERS = 4000  # of one argument: two definitions side by side fit
WINDOW = 60.0  # seconds
MAX_PER_MESSAGE = 10  # with the same `about` and message, in one window
MAX_IN_ALL = 100


def cut(text: object, limit: int = MAX_CHARACTERS) -> str:
    """The text, or its beginning and the number of characters left out."""
    whole = str(text)
    return whole if len(whole) <= limit else f"{whole[:limit]}... ({len(whole) - limit} characters more)"


class PeerLog:
    """A logger for events that peers cause: texts are cut, and repetitions are counted instead of logged.

    Use one for each node or master. Its memory is bounded. Thread-safe.

    Args:
        name: Name of the logger.
        monotonic: Clock, seconds.
    """

    def __init__(self, name: str, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._log = get_logger(name)
        self._monotonic = monotonic
        self._lock = threading.Lock()
        self._limits: BoundedCache[tuple[str, str], _RateLimit] = BoundedCache(256)
        self._all = _RateLimit(MAX_IN_ALL)

    def info(self, about: str, message: str, *args: object) -> None:
        """As `warning`."""
        self._say("info", about, message, args)

    def warning(self, about: str, message: str, *args: object, exc_info: BaseException | None = None) -> None:
        """Log a warning, unless the limit is reached.

        Args:
            about: The topic, service or address that it is about.
            message: Format for `args`, each of which is cut.
            exc_info: An error whose traceback is logged as well.
        """
        self._say("warning", about, message, args, exc_info)

    def error(self, about: str, message: str, *args: object, exc_info: BaseException | None = None) -> None:
        """As `warning`."""
        self._say("error", about, message, args, exc_info)

    def _say(
        self,
        level: str,
        about: str,
        message: str,
        args: tuple[object, ...],
        exc_info: BaseException | None = None,
    ) -> None:
        with self._lock:
            now, key = self._monotonic(), (about, message)
            limit = self._limits.get(key)
            if limit is None:
                limit = _RateLimit(MAX_PER_MESSAGE)
                self._limits.put(key, limit)
            if not (limit.allows(now) and self._all.allows(now)):
                limit.left_out += 1
                return
            left_out, limit.left_out = limit.left_out, 0
        if left_out:
            message, args = f"{message}; %d more like it were left out", (*args, left_out)
        say = getattr(self._log, level)
        options = {} if exc_info is None else {"exc_info": exc_info}
        say(message, *(a if isinstance(a, (int, float)) else cut(a) for a in args), stacklevel=3, **options)


class _RateLimit:
    """A limit on the number of records in a window of time.

    Attributes:
        left_out: Records left out since the last one that was logged.
    """

    __slots__ = ("_begun", "_left", "_limit", "left_out")

    def __init__(self, limit: int) -> None:
        self._limit = self._left = limit
        self._begun = -WINDOW
        self.left_out = 0

    def allows(self, now: float) -> bool:
        if now - self._begun >= WINDOW:
            self._begun, self._left = now, self._limit
        self._left -= 1
        return self._left >= 0


class _SingleLineFilter(logging.Filter):
    """Escapes line feeds and control characters, because records quote peers: no peer can forge a record or
    send commands to a terminal. No record is dropped.
    """

    def filter(self, record: logging.LogRecord) -> bool:
        text = record.getMessage()
        if not text.isprintable():
            record.msg, record.args = printable(text), ()
        return True


_SINGLE_LINE = _SingleLineFilter()


def get_logger(name: str) -> logging.Logger:
    """As `logging.getLogger(name)`; each record is one printable line."""
    logger = logging.getLogger(name)
    logger.addFilter(_SINGLE_LINE)  # adding it twice has no effect
    return logger
