"""Who asks: a page with a session of ours, or a program at an address. Safe from any thread."""

from __future__ import annotations

import itertools
import secrets
import threading
import time
from collections import OrderedDict
from dataclasses import dataclass

from rosproto.text import printable

__all__ = ["KEPT_SECONDS", "MOST_SESSIONS", "Client", "Clients"]

MOST_SESSIONS = 256
KEPT_SECONDS = 60.0
"""Seconds for which the session of a page that has gone can be taken up again."""


@dataclass(slots=True)
class Client:
    """One of them.

    Attributes:
        session: Secret; "" for a program.
        name: As others see them; no two have the same.
        address: Where they are.
        connected: Whether the page is connected now.
        last_connected: When it was connected last, by the monotonic clock.
    """

    session: str
    name: str
    address: str
    connected: bool = False
    last_connected: float = 0.0


class Clients:
    """Sessions of pages, by their secret; bounded: those that went first are forgotten first."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._known: OrderedDict[str, Client] = OrderedDict()

    def connect(self, address: str, session: str = "") -> Client | None:
        """A page connects, or connects again; None when there are too many."""
        now = time.monotonic()
        with self._lock:
            self._forget(now)
            client = self._known.get(session) if session else None
            if client is None or client.connected:
                if len(self._known) >= MOST_SESSIONS:
                    return None
                address = printable(address)[:60]
                name = f"page {next(self._numbers)} at {address}"
                client = Client(secrets.token_urlsafe(18), name, address)
                self._known[client.session] = client
            client.connected, client.last_connected = True, now
            return client

    def disconnect(self, client: Client) -> None:
        """A page has gone; it may come back for a while."""
        with self._lock:
            client.connected, client.last_connected = False, time.monotonic()
            if client.session in self._known:
                self._known.move_to_end(client.session)

    def by_session(self, session: str) -> Client | None:
        """Whose session it is, None when it is nobody's."""
        with self._lock:
            return self._known.get(session)

    @staticmethod
    def program(address: str) -> Client:
        """Somebody without a session: all programs at one address are one."""
        address = printable(address)[:60]
        return Client("", f"program at {address}", address)

    def _forget(self, now: float) -> None:
        gone = [
            p.session
            for p in self._known.values()
            if not p.connected and now - p.last_connected > KEPT_SECONDS
        ]
        for session in gone:
            del self._known[session]
        while len(self._known) >= MOST_SESSIONS:
            away = next((p.session for p in self._known.values() if not p.connected), None)
            if away is None:
                return
            del self._known[away]
