"""`Admission`: checks the HTTP request of a WebSocket handshake, before a connection becomes a client. Pure.

A browser lets any page open a WebSocket to any address and sends the page's origin with it. Without a check,
a page on the internet could reach a robot through its visitor's browser. Host, origin, token and subprotocol
are checked, and Host and Origin may appear only once.
"""

from __future__ import annotations

import hmac
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from rosproto.gateway.access import short
from rosproto.transport.uri import is_loopback


@dataclass(frozen=True, slots=True)
class AdmissionRefusal:
    """Why a request is refused.

    Attributes:
        status: HTTP status of the answer.
        reason: Key of the counter of refused connections.
        text: A sentence for the client and the log.
    """

    status: HTTPStatus
    reason: str
    text: str


@dataclass(frozen=True, slots=True)
class Admission:
    """The rules for connecting to one server.

    Attributes:
        bound: The address that the server listens on.
        origins: Origins of pages that may connect besides those of this computer, as a browser writes them;
            "*" for all. A client without an origin is not a browser.
        token: The secret that a client must send, as `?token=T` or `Authorization: Bearer T`; None for none.
        subprotocols: A client must offer one of these, the best first, unless there are none;
            `ClientChannel.subprotocol` is the agreed one.

    Raises:
        ValueError: Others can reach the address, and there is no token.
    """

    bound: str
    origins: Sequence[str] = ()
    token: str | None = None
    subprotocols: Sequence[str] = ()

    def __post_init__(self) -> None:
        require_token_off_loopback(self.bound, self.token)
        if isinstance(self.origins, str):
            raise ValueError(f"origins are a list of texts; for one alone write [{self.origins!r}]")

    def check(self, path: str, header: Callable[[str], Sequence[str]]) -> AdmissionRefusal | None:
        """Return why a request is refused, or None.

        Args:
            path: Path and query.
            header: Returns all values of a header.
        """
        hosts, origins = header("Host"), header("Origin")
        if len(hosts) > 1 or len(origins) > 1:
            return AdmissionRefusal(HTTPStatus.BAD_REQUEST, "headers", "a header is there twice")
        why = foreign_host(hosts[0] if hosts else None, self.bound)
        if why is not None:
            return AdmissionRefusal(HTTPStatus.FORBIDDEN, "host", why)
        why = foreign_origin(origins[0] if origins else None, self.origins)
        if why is not None:
            return AdmissionRefusal(HTTPStatus.FORBIDDEN, "origin", why)
        if not token_fits(_token(path, header("Authorization")), self.token):
            why = "the token is missing or wrong; give it as ?token=... or as Authorization: Bearer ..."
            return AdmissionRefusal(HTTPStatus.UNAUTHORIZED, "token", why)
        offered = {name.strip() for line in header("Sec-WebSocket-Protocol") for name in line.split(",")}
        if self.subprotocols and offered.isdisjoint(self.subprotocols):
            why = f"the client speaks none of the protocols {', '.join(self.subprotocols)}"
            return AdmissionRefusal(HTTPStatus.BAD_REQUEST, "protocol", why)
        return None


def _token(path: str, authorization: Sequence[str]) -> str | None:
    """The token in the request; None if it has none, or several."""
    if len(authorization) == 1 and authorization[0][:7].lower() == "bearer ":
        return authorization[0][7:].strip()
    try:
        values = parse_qs(urlsplit(path).query, max_num_fields=100).get("token", [])
    except ValueError:
        return None
    return values[0] if len(values) == 1 else None


def token_fits(given: str | None, expected: str | None) -> bool:
    """Whether the given token is right (compared in constant time), or none is required."""
    if expected is None:
        return True
    return hmac.compare_digest((given or "").encode("utf-8", "replace"), expected.encode("utf-8"))


def require_token_off_loopback(host: str, token: str | None) -> None:
    """Check that a gateway which other computers can reach has a token.

    Raises:
        ValueError: It has none, or the token is empty.
    """
    if token is not None and not token:
        raise ValueError("the token is empty; give a long random one")
    if token is None and not is_loopback(host):
        raise ValueError(
            f"{host or 'every address'} is reached from other computers, and who reaches a gateway sees the"
            f" robot: give a token (--token, in a program token=...), or listen on 127.0.0.1"
        )


def foreign_origin(origin: str | None, origins: Sequence[str]) -> str | None:
    """Return why a page of this origin may not connect, or None.

    Pages of this computer's own servers (`http://localhost:8080`) may connect.

    Args:
        origin: The Origin header; None if there is none.
        origins: Allowed origins, as a browser writes them; "*" for all.
    """
    if origin is None or origin in origins or "*" in origins:
        return None
    try:
        parts = urlsplit(origin)
        host = parts.hostname if parts.scheme in ("http", "https") else None
    except ValueError:
        host = None
    if host is not None and is_loopback(host):
        return None
    return (
        f"a page of {short(origin)!r} may not connect; open it with --origin {short(origin)}"
        if host is not None
        else f"a page whose origin is {short(origin)!r} may not connect"
    )


def foreign_host(host: str | None, bound: str) -> str | None:
    """Return why a server on the loopback refuses a request for this host, or None.

    Otherwise a page under a name that resolves to 127.0.0.1 would have the same origin as this server.

    Args:
        host: The Host header.
        bound: The address that the server listens on.
    """
    if not is_loopback(bound) or host is None:
        return None
    name = host.rpartition(":")[0] if host.rpartition(":")[2].isdigit() else host
    if is_loopback(name):
        return None
    return f"this gateway serves this computer alone, and {short(host)!r} is not its name: use localhost"
