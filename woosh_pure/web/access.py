"""Access to the web server: the rules of every server (`rosproto.admission`), log-ins, the rate of commands,
and the sessions of pages.
"""

from __future__ import annotations

import hashlib
import hmac
import itertools
import secrets
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from rosproto.admission import AddressBuckets, AdmissionPolicy, port_of, require_page_origin
from rosproto.deprecation import former_names
from rosproto.sentence import say
from rosproto.text import printable
from woosh_pure.web.http_errors import Problem


def cookie_name(host: str, scheme: str) -> str:
    """Return the name of the log-in cookie. It has the port, because browsers share cookies among ports."""
    usual = "443" if scheme in ("https", "wss") else "80"
    return f"woosh_login_{port_of(host) or usual}"


def cookies(header: str, name: str) -> list[str]:
    """Return the values of all cookies with that name. Nested paths can each have one."""
    pairs = (part.strip().partition("=") for part in header.split(";"))
    return [value for key, _, value in pairs if key == name]


class AccessRules(AdmissionPolicy):
    """The access rules of one application: those of every server, log-ins, and the rate of commands.

    Origins are those of web pages only; other servers also let in programs, "null" and "*".
    """

    def __init__(
        self, token: str | None = None, origins: Iterable[str] = (), hosts: Iterable[str] = ()
    ) -> None:
        super().__init__(token, map(require_page_origin, origins), hosts)
        self._key = b"" if token is None else _key_of(token)
        self._commands = AddressBuckets(rate=5.0, burst=10.0)

    def log_in(self, place: str) -> str:
        """Return the value of a log-in cookie, which a browser keeps in place of the token.

        It is valid as long as the token, also after a restart of the server, so that STOP on an open page
        needs no second log-in. It does not reveal the token, and is valid at this place only.

        Args:
            place: The cookie's name and the server's port.
        """
        number = secrets.token_urlsafe(18)
        return f"{number}.{self._mark_of(number, place)}"

    def is_logged_in(self, kept: Iterable[str], place: str) -> bool:
        """Whether one of these values is from `log_in` for this place."""
        if not self.needs_token:
            return False
        numbers = ((value.encode("utf-8", "surrogateescape"), value.partition(".")[0]) for value in kept)
        return any(
            hmac.compare_digest(value, f"{number}.{self._mark_of(number, place)}".encode("utf-8", "replace"))
            for value, number in numbers
        )

    def _mark_of(self, number: str, place: str) -> str:
        text = f"{place} {number}".encode("utf-8", "surrogateescape")
        return hmac.new(self._key, text, "sha256").hexdigest()

    def check_rate(self, address: str, now: float) -> Problem | None:
        """Limit commands to five a second, ten at once, from each address. A stop is never counted."""
        if self._commands.take(address, now):
            return None
        return Problem(429, "too many commands from this address; at most five a second")


def _key_of(token: str) -> bytes:
    """Derive a key slowly, so that a token cannot be guessed from a cookie."""
    return hashlib.pbkdf2_hmac("sha256", token.encode("utf-8", "surrogateescape"), b"woosh log-in", 100_000)


# -- clients: pages with sessions, and programs --------------------------------------------------------------

LEFT_SESSIONS = 192
"""Sessions of pages that are not connected, at least."""
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
        replaced: Called when another connection resumes the session; None while there is no connection.
    """

    session: str
    name: str
    address: str
    connected: bool = False
    last_connected: float = 0.0
    replaced: Callable[[], object] | None = None


class Clients:
    """The sessions of pages, by their secret. At the limit, the longest disconnected one is deleted."""

    def __init__(self, max_sessions: int) -> None:
        self._max_sessions = max_sessions
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._known: OrderedDict[str, Client] = OrderedDict()

    def connect(self, address: str, session: str = "") -> Client | None:
        """Connect a page, or resume its session. None if there are too many sessions.

        A reloaded page can connect before its old connection has ended, which is then replaced.
        """
        now, replaced = time.monotonic(), None
        with self._lock:
            self._forget(now)
            client = self._known.get(session) if session else None
            if client is not None:
                replaced, client.replaced = client.replaced, None
            else:
                if len(self._known) >= self._max_sessions:
                    return None
                address = printable(address)[:60]
                name = say("page {number} at {address}", number=next(self._numbers), address=address)
                client = Client(secrets.token_urlsafe(18), name, address)
                self._known[client.session] = client
            client.connected, client.last_connected = True, now
        if replaced is not None:
            replaced()
        return client

    def disconnect(self, client: Client) -> None:
        """Disconnect a page. It may resume its session for a while."""
        with self._lock:
            client.connected, client.last_connected, client.replaced = False, time.monotonic(), None
            if client.session in self._known:
                self._known.move_to_end(client.session)

    def by_session(self, session: str) -> Client | None:
        """Return the client with this session, or None."""
        with self._lock:
            return self._known.get(session)

    def is_page(self, name: str) -> bool:
        """Whether a page has this name, so that a person can be asked."""
        with self._lock:
            return any(client.name == name for client in self._known.values())

    def _forget(self, now: float) -> None:
        gone = [
            p.session
            for p in self._known.values()
            if not p.connected and now - p.last_connected > KEPT_SECONDS
        ]
        for session in gone:
            del self._known[session]
        while len(self._known) >= self._max_sessions:
            away = next((p.session for p in self._known.values() if not p.connected), None)
            if away is None:
                return
            del self._known[away]


__getattr__ = former_names(
    __name__,
    {n: f"rosproto.admission.{n}" for n in ("ConnectionSlots", "TokenBucket", "host_of")},
)
