"""What paho has taken and not written yet: bounded in number and bytes. Not for several threads at a time."""

from __future__ import annotations

from collections import deque
from typing import Any

__all__ = ["MOST_WAITING", "MOST_WAITING_BYTES", "Outbox"]

MOST_WAITING = 200
"""Messages of one vehicle that wait for a broker which does not read."""
MOST_WAITING_BYTES = 1_000_000


class Outbox:
    """Messages of quality 0 of one connection."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[Any, int]] = deque()
        self._bytes = 0

    def __len__(self) -> int:
        return len(self._waiting)

    def has_room(self, size: int) -> bool:
        """Whether one more may wait; one always may."""
        waiting = self._waiting
        while waiting and waiting[0][0].is_published():
            self._bytes -= waiting.popleft()[1]
        return not waiting or (len(waiting) < MOST_WAITING and self._bytes + size <= MOST_WAITING_BYTES)

    def add(self, info: Any, size: int) -> None:
        """A message waits, until paho's `info` says that it was written."""
        self._waiting.append((info, size))
        self._bytes += size

    def clear(self) -> None:
        """The connection is gone, and what waited with it."""
        self._waiting.clear()
        self._bytes = 0
