"""The `logging.Handler` of /rosout, apart because it needs `logging`."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosproto.node.rosout.rosout import Rosout

__all__ = ["RosoutHandler"]


class RosoutHandler(logging.Handler):
    """Publishes records."""

    def __init__(self, rosout: Rosout) -> None:
        super().__init__()
        self._rosout = rosout

    def emit(self, record: logging.LogRecord) -> None:
        """Publish one record; what goes wrong is `logging`'s to report (`raiseExceptions`)."""
        try:
            self._rosout.publish(record, self.format(record))
        except Exception:
            self.handleError(record)
