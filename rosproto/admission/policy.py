"""`AdmissionPolicy`: who may send requests to a server, by token, Host and Origin. Pure: headers and times
are arguments.

A browser sends requests for any page that is open in it, and a page of another site must not reach the robot
through it. `Origin` names the site of the page that sent a request, `Host` the name under which the server
was reached. By DNS rebinding an attacker can make another name point to this server, but not an IP address or
localhost. Programs do not send `Origin`, and pass that check.
"""

from __future__ import annotations

import base64
import hmac
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from http import HTTPStatus
from urllib.parse import urlsplit

from rosproto.admission.token_bucket import AddressBuckets
from rosproto.sentence import say
from rosproto.transport.uri import is_loopback, is_numeric

MIN_TOKEN = 8
MAX_CLIENTS = 64
"""Clients of a server at a time, unless it is told otherwise."""
Header = Callable[[str], Sequence[str]]
"""Returns all values of the header with this name."""

_AUTHORITY = re.compile(r"(?:\[([0-9A-Fa-f:.]+)\]|([A-Za-z0-9._-]+))(?::([0-9]{1,5}))?")
_PORTS = {"http": ":80", "https": ":443"}
_PROGRAM = re.compile(r"(?!https?:|wss?:|ftp:)[a-z][a-z0-9+.-]*://[^\s/?#]*")
"""The origin of a program that shows pages, as file:// or app://name."""


def host_of(header: str) -> str:
    """Return the lower case host name of a Host header or URL authority, without port; "" if malformed."""
    found = _AUTHORITY.fullmatch(header.strip())
    return "" if found is None else (found[1] or found[2]).rstrip(".").lower()


def port_of(header: str) -> str:
    """Return the port of a Host header; "" if it has none."""
    found = _AUTHORITY.fullmatch(header.strip())
    return (found and found[3]) or ""


def normal_origin(origin: str) -> str:
    """Return the origin of a web page in lower case and without a usual port; "" if it is not one."""
    try:
        parts = urlsplit(origin.strip())
        good = parts.scheme in _PORTS and parts.hostname and parts.path in ("", "/") and parts.port != 0
    except ValueError:
        return ""
    if not good or parts.query or parts.fragment:
        return ""
    netloc = parts.netloc.lower().rpartition("@")[2].removesuffix(_PORTS[parts.scheme])
    return f"{parts.scheme}://{netloc}"


def bearer_token(authorizations: Sequence[str]) -> str | None:
    """Return the token in the Authorization header; None if there is none, or several."""
    return _credentials(authorizations, "bearer")


def basic_password(authorizations: Sequence[str]) -> str | None:
    """Return the password in the Authorization header, of programs that know no tokens; None without one."""
    try:
        pair = base64.b64decode(_credentials(authorizations, "basic") or "", validate=True).decode()
    except ValueError:
        return None
    return pair.partition(":")[2] if ":" in pair else None


def _credentials(authorizations: Sequence[str], wanted: str) -> str | None:
    if len(authorizations) != 1:
        return None
    scheme, _, value = authorizations[0].partition(" ")
    return value.strip() if scheme.lower() == wanted else None


@dataclass(frozen=True, slots=True)
class AdmissionRefusal:
    """Why a request is refused.

    Attributes:
        status: HTTP status of the answer.
        reason: A short word for programs and counters.
        text: A sentence for the client and the log.
    """

    status: HTTPStatus
    reason: str
    text: str


class AdmissionPolicy:
    """The rules of one server.

    Args:
        token: The secret that requests must carry; with None, no request needs one.
        origins: Origins whose pages may send requests, besides pages of this server: "https://host:port", of
            programs "file://" or the like, "null", or "*" for all. Their host names are accepted as names of
            this server, too.
        hosts: Further host names under which this server may be reached.

    Attributes:
        needs_token: Whether requests need a token.

    Raises:
        ValueError: The token is too easy to guess or cannot be sent, or an origin is not valid.
    """

    def __init__(
        self, token: str | None = None, origins: Iterable[str] = (), hosts: Iterable[str] = ()
    ) -> None:
        if isinstance(origins, str):
            raise ValueError(f"origins must be a list of strings; for a single one write [{origins!r}]")
        if token is not None and len(token) < MIN_TOKEN:
            text = "the token is too short (length {count}); use at least {minimum} random characters"
            raise ValueError(say(text, count=len(token), minimum=MIN_TOKEN))
        if token is not None and not (token.isascii() and token.isprintable() and " " not in token):
            raise ValueError(say("the token cannot be sent in a header; use ASCII letters and digits"))
        self.needs_token = token is not None
        self._token = (token or "").encode()
        self._origins = frozenset(map(_require_origin, origins))
        of_origins = (urlsplit(origin).hostname or "" for origin in self._origins)
        self._hosts = frozenset(filter(None, (*of_origins, *map(host_of, hosts), "localhost")))
        self._wrong_tokens = AddressBuckets(rate=1.0 / 6.0, burst=10.0)

    def require_token_at(self, bind: str) -> None:
        """Check that a server which other computers can reach has a token.

        Raises:
            ValueError: It has none.
        """
        if not self.needs_token and not is_loopback(bind):
            text = (
                "--bind {bind} lets other computers connect: give a token (--token-file, at least {minimum} "
                "random characters; in a program token=...), or listen on 127.0.0.1"
            )
            raise ValueError(say(text, bind=bind or "''", minimum=MIN_TOKEN))

    def check_headers(self, header: Header, scheme: str, *, changes: bool) -> AdmissionRefusal | None:
        """Check Host, and Origin where a request may change something or reads on (a WebSocket).

        Args:
            header: Returns the values of a header.
            scheme: Of the request: the same host with another scheme is another origin.
            changes: Whether to check Origin.
        """
        hosts, origins = header("host"), header("origin")
        if len(hosts) > 1 or len(origins) > 1:
            text = say("the header Host or Origin was sent more than once")
            return AdmissionRefusal(HTTPStatus.BAD_REQUEST, "headers", text)
        host, origin = "".join(hosts), origins[0] if origins else None
        refusal = self.check_host(host)
        if refusal is None and changes:
            refusal = self.check_origin(origin, host, scheme, "".join(header("sec-fetch-site")) or None)
        return refusal

    def check_host(self, host: str | None) -> AdmissionRefusal | None:
        """Accept localhost, IP addresses, and the host names that were given."""
        name = host_of(host or "")
        if name in self._hosts or is_numeric(name):
            return None
        text = say(
            "this server is not called {name!r:.80}; call it by its address, or start it with "
            "--host-name NAME (a page of another name could reach the robot through it)",
            name=name,
        )
        return AdmissionRefusal(HTTPStatus.MISDIRECTED_REQUEST, "host", text)

    def check_origin(
        self, origin: str | None, host: str | None, scheme: str, site: str | None = None
    ) -> AdmissionRefusal | None:
        """Accept pages of this server, allowed origins, and programs, which send no origin.

        Args:
            origin: The header Origin.
            host: The header Host.
            scheme: The scheme of the request.
            site: The header Sec-Fetch-Site.
        """
        if origin is None:
            allowed = site in (None, "same-origin", "none")
        else:
            secure = scheme in ("https", "wss")
            own = normal_origin(f"{'https' if secure else 'http'}://{host or ''}")
            asked = normal_origin(origin)
            allowed = bool({"*", origin, asked} & self._origins) or "" != asked == own
        if allowed:
            return None
        text = "a page of {origin!r:.100} is not allowed here; --origin URL allows the pages of an address"
        return AdmissionRefusal(HTTPStatus.FORBIDDEN, "origin", say(text, origin=origin or site or ""))

    def check_token(self, given: str | None, address: str, now: float) -> AdmissionRefusal | None:
        """Accept the right token. Answer ten wrong ones of an address at once, then one every six seconds."""
        if not self.needs_token:
            return None
        if given is None:
            text = say(
                "this needs the token that the server was started with; send it as `Authorization: Bearer "
                "TOKEN` (a page logs in, and a gateway also takes ?token=TOKEN in its address)"
            )
            return AdmissionRefusal(HTTPStatus.UNAUTHORIZED, "token", text)
        if hmac.compare_digest(given.encode("utf-8", "surrogateescape"), self._token):
            return None
        if self._wrong_tokens.take(address, now):
            text = say("this is not the token that the server was started with")
            return AdmissionRefusal(HTTPStatus.UNAUTHORIZED, "wrong-token", text)
        text = say("too many wrong tokens from this address; wait a minute")
        return AdmissionRefusal(HTTPStatus.TOO_MANY_REQUESTS, "too-many-tokens", text)


def require_page_origin(origin: str) -> str:
    """Return the normal form of a web page's origin.

    Raises:
        ValueError: It is not one.
    """
    if found := normal_origin(origin):
        return found
    text = "{origin!r} is not an origin; expected one like https://robot.example:8080"
    raise ValueError(say(text, origin=origin))


def _require_origin(origin: str) -> str:
    if origin in ("*", "null") or _PROGRAM.fullmatch(origin):
        return origin
    return require_page_origin(origin)
