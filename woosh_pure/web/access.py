"""Who may ask: token, Host, Origin, and how often. Pure: headers and times are given.

A browser sends requests for whatever page is open in it. So a page of somebody else must not reach the robot
on this computer: `Origin` says whose page asks, and `Host` by which name the server was found. DNS rebinding
makes a foreign name point at us; an address in numbers, or localhost, cannot be made to. Programs send
neither and pass.
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
    """Why a request is not answered: a status of HTTP, and a sentence."""

    status: int
    text: str


def host_of(header: str) -> str:
    """The name in a Host header or an authority, without its port, in small letters; "" when it is none."""
    found = _AUTHORITY.fullmatch(header.strip())
    return "" if found is None else (found[1] or found[2]).rstrip(".").lower()


def is_loopback(address: str) -> bool:
    """Whether an address to bind to is reachable from this computer only."""
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
    """So many at once, and so many a second. Pure."""

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
    """The rules of one application.

    Args:
        token: What every request must carry; None lets everybody in.
        origins: Pages that may ask beside our own, as "https://host:port"; their hosts are names of ours,
            too.
        hosts: More names by which this server may be called.

    Raises:
        ValueError: A token that can be guessed, or an origin that is none.
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
        """Whether a token is asked for."""
        return self._token is not None

    def check_host(self, host: str | None) -> Refusal | None:
        """A name of ours: localhost, an address in numbers, or one that was given."""
        name = host_of(host or "")
        if name in self._hosts or _is_number(name):
            return None
        return Refusal(
            421,
            f"this server is not called {name[:80]!r}; call it by its address, or start it with "
            "--host-name NAME (a page of another name could reach the robot through it)",
        )

    def check_origin(self, origin: str | None, host: str | None, site: str | None = None) -> Refusal | None:
        """Our own page, a page that was allowed, or no page at all."""
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
        """The right token. Who guesses is slowed down: ten at once, then one every six seconds."""
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
        """For what moves: five a second, ten at once, for each address. A stop is never counted."""
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
    """As browsers write it: scheme and authority, in small letters; "" for what is none."""
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
