"""Who sends requests: a page with a session, or a program at an address. Safe from any thread."""

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
"""Seconds for which a page can resume its session after its connection has ended."""


@dataclass(slots=True)
class Client:
    """A page or a program.

    Attributes:
        session: The secret of the page's session; "" for a program.
        name: The name that others see; unique among pages.
        address: IP address.
        connected: Whether the page is connected now.
        last_connected: When it was connected last, by the monotonic clock.
    """

    session: str
    name: str
    address: str
    connected: bool = False
    last_connected: float = 0.0


class Clients:
    """The sessions of pages, by their secret. At the limit, the longest disconnected one is forgotten."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._known: OrderedDict[str, Client] = OrderedDict()

    def connect(self, address: str, session: str = "") -> Client | None:
        """A page connects, or resumes its session. None if there are too many sessions."""
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
        """A page has disconnected. It may resume its session for a while."""
        with self._lock:
            client.connected, client.last_connected = False, time.monotonic()
            if client.session in self._known:
                self._known.move_to_end(client.session)

    def by_session(self, session: str) -> Client | None:
        """The client that has this session, or None."""
        with self._lock:
            return self._known.get(session)

    @staticmethod
    def program(address: str) -> Client:
        """A client without a session. All programs at one address count as one client."""
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
