"""Who may send requests: token, Host, Origin, and the rate. Pure: headers and times are arguments.

A browser sends requests on behalf of any page that is open in it. A page from somebody else's site must not
reach the robot through the browser on this computer. `Origin` tells which site's page sent the request, and
`Host` under which name the server was reached. By DNS rebinding an attacker can make a foreign name point to
this server, but not an IP address or localhost. Programs do not send `Origin`, and pass that check.
"""

from __future__ import annotations

import hmac
import ipaddress
import math
import re
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, field
from urllib.parse import urlsplit

__all__ = ["Access", "Refusal", "TokenBucket", "host_of", "is_loopback"]

COOKIE = "woosh_token"
_AUTHORITY = re.compile(r"(?:\[([0-9A-Fa-f:.]+)\]|([A-Za-z0-9._-]+))(?::[0-9]{1,5})?")
LEAST_TOKEN = 8
MOST_BUCKETS = 1000


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why a request is refused: an HTTP status and a sentence."""

    status: int
    text: str


def host_of(header: str) -> str:
    """The lower-case name in a Host header or a URL's authority, without the port; "" if it is malformed."""
    found = _AUTHORITY.fullmatch(header.strip())
    return "" if found is None else (found[1] or found[2]).rstrip(".").lower()


def is_loopback(address: str) -> bool:
    """Whether an address to listen on can be reached from this computer only."""
    if address.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(address.strip("[]")).is_loopback
    except ValueError:
        return False


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
    _level: float = field(default=math.nan)
    _then: float = 0.0

    def take(self, now: float) -> bool:
        """Whether one more is allowed now."""
        if math.isnan(self._level):
            self._level, self._then = self.burst, now
        self._level = min(self.burst, self._level + max(0.0, now - self._then) * self.rate)
        self._then = now
        if self._level < 1.0:
            return False
        self._level -= 1.0
        return True


class Access:
    """The access rules of one application.

    Args:
        token: The secret that every request must carry; None lets everybody in.
        origins: Origins whose pages may send requests, besides our own page, as "https://host:port". Their
            host names are accepted as names of this server, too.
        hosts: Further host names under which this server may be reached.

    Raises:
        ValueError: The token is too easy to guess, or an origin is not valid.
    """

    def __init__(
        self, token: str | None = None, origins: Iterable[str] = (), hosts: Iterable[str] = ()
    ) -> None:
        if token is not None and len(token) < LEAST_TOKEN:
            raise ValueError(
                f"the token has {len(token)} letters; give at least {LEAST_TOKEN}, made by chance"
            )
        if token is not None and not (token.isascii() and token.isprintable() and " " not in token):
            raise ValueError("the token has letters that no header can carry; take ASCII letters and digits")
        self._token = None if token is None else token.encode("utf-8", "surrogateescape")
        self._origins = frozenset(_origin(origin) for origin in origins)
        named = (urlsplit(origin).hostname or "" for origin in self._origins)
        self._hosts = frozenset(filter(None, (*named, *(host_of(host) for host in hosts), "localhost")))
        self._moves: OrderedDict[str, TokenBucket] = OrderedDict()
        self._guesses: OrderedDict[str, TokenBucket] = OrderedDict()

    @property
    def needs_token(self) -> bool:
        """Whether requests need a token."""
        return self._token is not None

    def check_host(self, host: str | None) -> Refusal | None:
        """Accept localhost, IP addresses, and the host names that were given."""
        name = host_of(host or "")
        if name in self._hosts or _is_number(name):
            return None
        return Refusal(
            421,
            f"this server is not called {name[:80]!r}; call it by its address, or start it with "
            "--host-name NAME (a page of another name could reach the robot through it)",
        )

    def check_origin(self, origin: str | None, host: str | None, site: str | None = None) -> Refusal | None:
        """Accept our own page, an origin that was allowed, and programs, which are no page at all."""
        if origin is None:
            if site in (None, "same-origin", "none"):
                return None
        else:
            asked = _origin(origin, strict=False)
            own = urlsplit(asked).netloc if asked else ""
            if asked and (asked in self._origins or own == (host or "").lower()):
                return None
        return Refusal(
            403,
            f"a page of {(origin or site or '')[:100]!r} may not do this; only the page of this server may",
        )

    def check_token(self, given: str | None, who: str, now: float) -> Refusal | None:
        """Accept the right token. Guessing is slowed down to ten at once, then one every six seconds."""
        if self._token is None:
            return None
        bucket = _bucket(self._guesses, who, 1.0 / 6.0, 10.0)
        if given is not None and hmac.compare_digest(given.encode("utf-8", "surrogateescape"), self._token):
            return None
        if given is not None and not bucket.take(now):
            return Refusal(429, "too many wrong tokens from this address; wait a minute")
        missing = "this needs the token that `woosh web` was started with" if given is None else "wrong token"
        return Refusal(401, f"{missing}; send it as `Authorization: Bearer TOKEN`, or log in")

    def check_rate(self, who: str, now: float) -> Refusal | None:
        """Limit commands to five a second, ten at once, from each address. A stop is never counted."""
        if _bucket(self._moves, who, 5.0, 10.0).take(now):
            return None
        return Refusal(429, "too many orders at once from this address; at most five a second")


def _bucket(buckets: OrderedDict[str, TokenBucket], who: str, rate: float, burst: float) -> TokenBucket:
    bucket = buckets.pop(who, None) or TokenBucket(rate, burst)
    buckets[who] = bucket
    while len(buckets) > MOST_BUCKETS:
        buckets.popitem(last=False)
    return bucket


_PORTS = {"http": ":80", "https": ":443"}


def _origin(origin: str, *, strict: bool = True) -> str:
    """An origin as browsers write it: scheme and authority in lower case; "" if it is not valid."""
    try:
        parts = urlsplit(origin.strip())
        good = parts.scheme in _PORTS and parts.hostname and parts.path in ("", "/")
        good = bool(good and not parts.query and not parts.fragment and parts.port != 0)
    except ValueError:
        good = False
    if not good:
        if strict:
            raise ValueError(f"{origin!r} is no origin; expected one like https://robot.example:8080")
        return ""
    netloc = parts.netloc.lower().rpartition("@")[2].removesuffix(_PORTS[parts.scheme])
    return f"{parts.scheme}://{netloc}"
