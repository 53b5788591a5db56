"""Ends one call of a service from another thread."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rosproto.errors import ConnectionLost
from rosproto.node.services.link import ServiceLink


class Cancellation:
    """A way to end one call from another thread, used by the asyncio face."""

    __slots__ = ("_link", "_lock", "cancelled")

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._link: ServiceLink | None = None
        self.cancelled = False

    def cancel(self) -> None:
        """End the call: if its request has not been sent, it will not be."""
        with self._lock:
            self.cancelled = True
            if self._link is not None:
                self._link.close()

    @contextmanager
    def covering(self, link: ServiceLink) -> Iterator[None]:
        """The link that `cancel` closes meanwhile."""
        with self._lock:
            if self.cancelled:
                raise ConnectionLost("the call was cancelled before its request was sent", peer=link.peer)
            self._link = link
        try:
            yield
        finally:
            with self._lock:
                self._link = None
