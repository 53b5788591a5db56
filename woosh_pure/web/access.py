"""Access to the server: token, log-in, Host, Origin and rate; sessions of pages; slots for connections. Pure:
headers and times are arguments.

A browser sends requests for any page that is open in it, and a page of another site must not reach the robot
through it. `Origin` names the site of the page that sent a request, `Host` the name under which the server
was reached. By DNS rebinding an attacker can make another name point to this server, but not an IP address or
localhost. Programs do not send `Origin`, and pass that check.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import itertools
import math
import re
import secrets
import threading
import time
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from urllib.parse import urlsplit

from rosproto.bounded_cache import BoundedCache
from rosproto.sentence import say
from rosproto.text import printable
from rosproto.transport import is_loopback
from woosh_pure.web.http_errors import Problem

_AUTHORITY = re.compile(r"(?:\[([0-9A-Fa-f:.]+)\]|([A-Za-z0-9._-]+))(?::([0-9]{1,5}))?")
LEAST_TOKEN = 8
NO_TOKEN = (
    "this needs the token that `woosh web` was started with; send it as `Authorization: Bearer TOKEN`, "
    "or log in"
)
WRONG_TOKEN = (
    "this is not the token that `woosh web` was started with; send it as `Authorization: Bearer TOKEN`, "
    "or log in"
)
MOST_BUCKETS = 1000


def host_of(header: str) -> str:
    """Return the lower case host name of a Host header or URL authority, without port; "" if malformed."""
    found = _AUTHORITY.fullmatch(header.strip())
    return "" if found is None else (found[1] or found[2]).rstrip(".").lower()


def cookie_name(host: str, scheme: str) -> str:
    """Return the name of the log-in cookie. It has the port, because browsers share cookies among ports."""
    found = _AUTHORITY.fullmatch(host.strip())
    usual = "443" if scheme in ("https", "wss") else "80"
    return f"woosh_login_{(found and found[3]) or usual}"


def cookies(header: str, name: str) -> list[str]:
    """Return the values of all cookies with that name. Nested paths can each have one."""
    pairs = (part.strip().partition("=") for part in header.split(";"))
    return [value for key, _, value in pairs if key == name]


def _is_number(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


@dataclass(slots=True)
class TokenBucket:
    """A rate limit: at most `burst` at once, and `rate` per second after that. Pure."""

    rate: float
    burst: float
    _level: float = math.inf
    _then: float = 0.0

    def take(self, now: float) -> bool:
        """Whether one more is allowed now."""
        self._level = min(self.burst, self._level + max(0.0, now - self._then) * self.rate)
        self._then = now
        if self._level < 1.0:
            return False
        self._level -= 1.0
        return True


class AccessRules:
    """The access rules of one application.

    Args:
        token: The secret that every request must carry; with None, no request needs one.
        origins: Origins whose pages may send requests, besides our own page, as "https://host:port". Their
            host names are accepted as names of this server, too.
        hosts: Further host names under which this server may be reached.

    Attributes:
        needs_token: Whether requests need a token.

    Raises:
        ValueError: The token is too easy to guess, or an origin is not valid.
    """

    def __init__(
        self, token: str | None = None, origins: Iterable[str] = (), hosts: Iterable[str] = ()
    ) -> None:
        if token is not None and len(token) < LEAST_TOKEN:
            raise ValueError(
                say(
                    "the token has {count} letters; give at least {least_token}, made by chance",
                    count=len(token),
                    least_token=LEAST_TOKEN,
                )
            )
        if token is not None and not (token.isascii() and token.isprintable() and " " not in token):
            raise ValueError("the token has letters that no header can carry; take ASCII letters and digits")
        self.needs_token = token is not None
        self._token = None if token is None else token.encode("utf-8", "surrogateescape")
        self._key = b"" if token is None else _key_of(token)
        self._origins = frozenset(map(_require_origin, origins))
        named = (urlsplit(origin).hostname or "" for origin in self._origins)
        self._hosts = frozenset(filter(None, (*named, *(host_of(host) for host in hosts), "localhost")))
        self._moves: BoundedCache[str, TokenBucket] = BoundedCache(MOST_BUCKETS)
        self._guesses: BoundedCache[str, TokenBucket] = BoundedCache(MOST_BUCKETS)

    def check_host(self, host: str | None) -> Problem | None:
        """Accept localhost, IP addresses, and the host names that were given."""
        name = host_of(host or "")
        if name in self._hosts or _is_number(name):
            return None
        return Problem(
            421,
            "this server is not called {name!r:.80}; call it by its address, or start it with "
            "--host-name NAME (a page of another name could reach the robot through it)",
            name=name,
        )

    def check_origin(
        self, origin: str | None, host: str | None, scheme: str, site: str | None = None
    ) -> Problem | None:
        """Accept our own page, allowed origins, and programs, which send no origin.

        Args:
            origin: The header Origin.
            host: The header Host.
            scheme: The scheme of the request: the same host with another scheme is another origin.
            site: The header Sec-Fetch-Site.
        """
        if origin is None:
            if site in (None, "same-origin", "none"):
                return None
        else:
            asked = _origin(origin)
            secure = scheme in ("https", "wss")
            own = _origin(f"{'https' if secure else 'http'}://{host or ''}")
            if asked and (asked in self._origins or asked == own):
                return None
        return Problem(
            403,
            "a page of {origin!r:.100} may not do this; only the page of this server may",
            origin=origin or site or "",
        )

    def check_token(self, given: str | None, who: str, now: float) -> Problem | None:
        """Accept the right token. Limit wrong tokens to ten at once, then one every six seconds."""
        if self._token is None:
            return None
        bucket = _bucket(self._guesses, who, 1.0 / 6.0, 10.0)
        if given is not None and hmac.compare_digest(given.encode("utf-8", "surrogateescape"), self._token):
            return None
        if given is not None and not bucket.take(now):
            return Problem(429, "too many wrong tokens from this address; wait a minute", "too-many-tokens")
        if given is None:
            return Problem(401, NO_TOKEN)
        return Problem(401, WRONG_TOKEN, "wrong-token")

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
        if self._token is None:
            return False
        numbers = ((value.encode("utf-8", "surrogateescape"), value.partition(".")[0]) for value in kept)
        return any(
            hmac.compare_digest(value, f"{number}.{self._mark_of(number, place)}".encode("utf-8", "replace"))
            for value, number in numbers
        )

    def _mark_of(self, number: str, place: str) -> str:
        text = f"{place} {number}".encode("utf-8", "surrogateescape")
        return hmac.new(self._key, text, "sha256").hexdigest()

    def check_rate(self, who: str, now: float) -> Problem | None:
        """Limit commands to five a second, ten at once, from each address. A stop is never counted."""
        if _bucket(self._moves, who, 5.0, 10.0).take(now):
            return None
        return Problem(429, "too many orders at once from this address; at most five a second")


def _key_of(token: str) -> bytes:
    """Derive a key slowly, so that a token cannot be guessed from a cookie."""
    return hashlib.pbkdf2_hmac("sha256", token.encode("utf-8", "surrogateescape"), b"woosh log-in", 100_000)


def _bucket(buckets: BoundedCache[str, TokenBucket], who: str, rate: float, burst: float) -> TokenBucket:
    bucket = buckets.get(who) or TokenBucket(rate, burst)
    buckets.put(who, bucket)
    return bucket


_PORTS = {"http": ":80", "https": ":443"}


def _origin(origin: str) -> str:
    """Return an origin as browsers write it, scheme and authority in lower case; "" if invalid."""
    try:
        parts = urlsplit(origin.strip())
        good = parts.scheme in _PORTS and parts.hostname and parts.path in ("", "/") and parts.port != 0
    except ValueError:
        return ""
    if not good or parts.query or parts.fragment:
        return ""
    netloc = parts.netloc.lower().rpartition("@")[2].removesuffix(_PORTS[parts.scheme])
    return f"{parts.scheme}://{netloc}"


def _require_origin(origin: str) -> str:
    if not (found := _origin(origin)):
        raise ValueError(
            say("{origin!r} is no origin; expected one like https://robot.example:8080", origin=origin)
        )
    return found


# -- clients: pages with sessions, and programs --------------------------------------------------------------

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

    def __init__(self) -> None:
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
                if len(self._known) >= MOST_SESSIONS:
                    return None
                address = printable(address)[:60]
                name = f"page {next(self._numbers)} at {address}"
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
        while len(self._known) >= MOST_SESSIONS:
            away = next((p.session for p in self._known.values() if not p.connected), None)
            if away is None:
                return
            del self._known[away]


# -- connection slots ----------------------------------------------------------------------------------------

MOST_CONNECTIONS, RESERVED, EACH = 256, 64, 64
"""All slots; those reserved for known addresses; and how many an unknown address can have."""
SILENT_SECONDS = 10.0
"""Seconds allowed before the first request, and between requests."""
KNOWN_SECONDS, MOST_KNOWN = 900.0, 256

Key = tuple[str, int]
"""IP address and port of the peer."""


@dataclass(slots=True)
class _Slot:
    since: float
    end: Callable[[], object]
    requests: int = 0
    authorized: int = 0


class ConnectionSlots:
    """Each connection takes a slot before anything is read from it. Pure: times are arguments.

    Any peer can open connections and send nothing, or half a request. So the number of slots is limited, and
    some are reserved for addresses that have presented the token recently. A connection that is silent for
    too long loses its slot. When all slots are taken, a new connection replaces one without an authorized
    request: the longest silent one of the address with the most of those. So a stop gets through even if
    unfinished requests fill all slots.

    Used in the event loop only. The `end` callbacks close a connection and must not wait.

    Args:
        most: The number of slots.
        reserved: How many of these are reserved for known addresses.
        each: How many slots an unknown address can have.
        silence: Seconds without a request after which a slot is lost.
    """

    def __init__(
        self,
        most: int = MOST_CONNECTIONS,
        reserved: int = RESERVED,
        each: int = EACH,
        silence: float = SILENT_SECONDS,
    ) -> None:
        self._most, self._reserved, self._each, self._silence = most, reserved, each, silence
        self._slots: dict[Key, _Slot] = {}
        self._known: BoundedCache[str, float] = BoundedCache(MOST_KNOWN)

    def __len__(self) -> int:
        return len(self._slots)

    def admit(self, key: Key, end: Callable[[], object], now: float) -> bool:
        """Give a new connection a slot. False if there is none."""
        self.drop_silent(now)
        address, known = key[0], self._is_known(key[0], now)
        own = sum(other[0] == address for other in self._slots)
        if not known and own >= self._each and not self._evict(now, address):
            return False
        most = self._most if known else self._most - self._reserved
        if len(self._slots) >= most and not self._evict(now):
            return False
        self._slots[key] = _Slot(now, end)
        return True

    def closed(self, key: Key, end: Callable[[], object]) -> None:
        """Free the slot of a closed connection. A newer one from the same address and port keeps its slot."""
        slot = self._slots.get(key)
        if slot is not None and slot.end == end:
            del self._slots[key]

    def request_begins(self, key: Key, now: float, *, authorized: bool) -> None:
        """Note the start of a request. A new connection does not replace one with an `authorized` request."""
        slot = self._slots.get(key)
        if slot is not None:
            slot.requests += 1
            slot.authorized += authorized

    def remember(self, address: str, now: float) -> None:
        """Note that a client at this address has presented the token."""
        self._known.put(address, now)

    def request_ends(self, key: Key, now: float, *, authorized: bool) -> None:
        """Note the end of a request; the connection may send another."""
        slot = self._slots.get(key)
        if slot is not None:
            slot.requests, slot.authorized, slot.since = slot.requests - 1, slot.authorized - authorized, now

    def drop_silent(self, now: float) -> None:
        """Drop connections that have been silent for too long. To be called every second or so."""
        for key, slot in list(self._slots.items()):
            if not slot.requests and now - slot.since > self._silence:
                self._close(key)

    def drop_all(self) -> None:
        """Drop all remaining connections."""
        for key in list(self._slots):
            self._close(key)

    def _is_known(self, address: str, now: float) -> bool:
        then = self._known.get(address)
        return is_loopback(address) or (then is not None and now - then < KNOWN_SECONDS)

    def _evict(self, now: float, address: str | None = None) -> bool:
        """Drop an idle connection, of that address or of any; False if none is idle."""
        idle = {key: slot for key, slot in self._slots.items() if not slot.authorized}
        if address is not None:
            idle = {key: slot for key, slot in idle.items() if key[0] == address}
        if not idle:
            return False
        crowd = Counter(key[0] for key in idle)
        self._close(min(idle, key=lambda key: (idle[key].requests > 0, -crowd[key[0]], idle[key].since)))
        return True

    def _close(self, key: Key) -> None:
        self._slots.pop(key).end()
