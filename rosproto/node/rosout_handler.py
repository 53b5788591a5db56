"""The `logging.Handler` of /rosout, apart because it needs `logging`."""

from __future__ import annotations

import logging
from collections.abc import Callable


class RosoutHandler(logging.Handler):
    """Publishes records, with the text that the formatter makes of them."""

    def __init__(self, publish: Callable[[logging.LogRecord, str], None]) -> None:
        super().__init__()
        self._publish = publish

    def emit(self, record: logging.LogRecord) -> None:
        """Publish one record; what goes wrong is `logging`'s to report (`raiseExceptions`)."""
        try:
            self._publish(record, self.format(record))
        except Exception:
            self.handleError(record)
