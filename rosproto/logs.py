"""Loggers that import `logging` when there is something to say.

`logging` and what it pulls in cost a sixth of the time that `import rosproto.node` took, and most programs
never see a record. One below WARNING that arises before the program itself imported `logging` could not be
seen by anybody: no handler and no level can be set without it.
"""

from __future__ import annotations

import sys
from functools import cache
from typing import TYPE_CHECKING, Any

from rosproto.text import printable

if TYPE_CHECKING:
    from logging import Filter, Logger, LogRecord

__all__ = ["get_logger"]

_UNSEEN = ("debug", "info")


def get_logger(name: str) -> Logger:
    """What `logging.getLogger(name)` gives, found when it is first used."""
    late: Any = _LateLogger(name)
    return late  # type: ignore[no-any-return]


class _LateLogger:
    """Gives the methods of the real logger, so that a record names the line that called it."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        if attribute in _UNSEEN and "logging" not in sys.modules:
            return _say_nothing
        if attribute == "_logger":
            import logging

            self._logger = logging.getLogger(self._name)
            self._logger.addFilter(_one_line())  # the same one twice is one
            return self._logger
        try:
            logger = self._logger
        except OSError:
            return _say_nothing  # no file can be opened any more: nor is there a place for the record
        return getattr(logger, attribute)

    def __repr__(self) -> str:
        return f"<logger {self._name}>"


@cache
def _one_line() -> Filter:
    """Peers are quoted in records: none of them writes a line of its own, or commands to the terminal."""
    import logging

    class OneLine(logging.Filter):
        """Lets every record through, its text escaped where it must be."""

        def filter(self, record: LogRecord) -> bool:
            text = record.getMessage()
            if not text.isprintable():
                record.msg, record.args = printable(text), ()
            return True

    return OneLine()


def _say_nothing(*_: object, **__: object) -> None:
    """A record that nobody can see."""
