"""What other threads leave for the one that owns the order machine: messages, calls, flags, and due times."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from woosh_pure.fleet.order.effects import Effect

__all__ = ["MOST_MESSAGES", "Inbox", "Left"]

MOST_MESSAGES = 100
"""Messages of a fleet manager that wait; more are dropped, counted and logged."""


class Left(NamedTuple):
    """What has been left since the last look.

    Attributes:
        flags: What has changed, by a word.
        calls: To be made in their order; each gives effects of the order machine.
        messages: (topic, payload) pairs of the fleet manager.
    """

    flags: set[str]
    calls: list[Callable[[], list[Effect]]]
    messages: list[tuple[str, bytes]]


class Inbox:
    """One reader, any number of writers.

    Attributes:
        due: When something is to be done, by the monotonic clock; the reader's own.
        dropped: Messages for which there was no room.
        closed: Nothing is read any more.
    """

    def __init__(self) -> None:
        self.due: dict[str, float] = {}
        self.dropped = 0
        self.closed = False
        self._wake = threading.Condition()
        self._flags: set[str] = set()
        self._calls: deque[Callable[[], list[Effect]]] = deque()
        self._messages: deque[tuple[str, bytes]] = deque()

    def flag(self, name: str) -> None:
        """Say that something has changed."""
        with self._wake:
            self._flags.add(name)
            self._wake.notify_all()

    def call(self, call: Callable[[], list[Effect]]) -> None:
        """Have something done in the reader's thread."""
        with self._wake:
            self._calls.append(call)
            self._wake.notify_all()

    def add_message(self, topic: str, payload: bytes) -> bool:
        """Leave a message; False when there is no room for it."""
        with self._wake:
            if len(self._messages) >= MOST_MESSAGES:
                self.dropped += 1
                return False
            self._messages.append((topic, payload))
            self._wake.notify_all()
            return True

    @property
    def waiting_messages(self) -> int:
        """How many messages have not been read."""
        return len(self._messages)

    def close(self) -> bool:
        """Wake the reader up for the last time; False when that was done before."""
        with self._wake:
            first, self.closed = not self.closed, True
            self._wake.notify_all()
            return first

    def wait(self) -> Left | None:
        """Wait until something is left or due, and take it; None when the inbox is closed."""
        with self._wake:
            while not (self.closed or self._flags or self._calls or self._messages):
                wait = min(self.due.values()) - time.monotonic()
                if wait <= 0.0:
                    break
                self._wake.wait(wait)
            if self.closed:
                return None
            left = Left(self._flags, list(self._calls), list(self._messages))
            self._flags = set()
            self._calls.clear()
            self._messages.clear()
            return left
