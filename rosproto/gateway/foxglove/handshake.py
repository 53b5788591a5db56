"""The opening handshake of a WebSocket: parsed, checked, and rewritten for the SDK's server. Pure functions.

Only the HTTP/1.1 heads are read (RFC 6455, sections 4.1 and 4.2); the frames that follow are between the SDK
and the client.

A client names the subprotocols it speaks. The SDK accepts `foxglove.sdk.v1` only; older viewers offer
`foxglove.websocket.v1`, the former name of the same messages, and are answered with the name they offered.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple
from urllib.parse import parse_qs, urlsplit

from rosproto.gateway.strangers import foreign_host, foreign_origin, token_fits

__all__ = [
    "HEAD_END",
    "MAX_HEAD_BYTES",
    "PROTOCOL",
    "BadRequest",
    "Request",
    "check_request",
    "client_response",
    "error_response",
    "parse_request",
    "text_frame",
    "upstream_request",
]

HEAD_END = b"\r\n\r\n"
MAX_HEAD_BYTES = 16 << 10
PROTOCOL, LEGACY_PROTOCOL = "foxglove.sdk.v1", "foxglove.websocket.v1"

_REASONS = {
    400: "Bad Request",
    401: "Unauthorized",
    403: "Forbidden",
    405: "Method Not Allowed",
    426: "Upgrade Required",
    431: "Request Header Fields Too Large",
    503: "Service Unavailable",
}


class BadRequest(Exception):
    """A request that is refused.

    Attributes:
        status: HTTP status.
        text: Why, in one sentence.
    """

    def __init__(self, status: int, text: str) -> None:
        super().__init__(text)
        self.status = status
        self.text = text


class Request(NamedTuple):
    """The head of a request.

    Attributes:
        target: Path and query.
        headers: By lower-case name; repeated ones are joined by commas.
    """

    target: str
    headers: dict[str, str]

    @property
    def token(self) -> str | None:
        """From `Authorization: Bearer T`, or `?token=T` (a browser cannot set headers)."""
        kind, _, given = self.headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer" and given.strip():
            return given.strip()
        try:
            values = parse_qs(urlsplit(self.target).query, max_num_fields=20).get("token")
        except ValueError:
            return None
        return values[0] if values else None

    @property
    def protocol(self) -> str | None:
        """The name under which the client offers our protocol; None when it does not."""
        names = [name.strip() for name in self.headers.get("sec-websocket-protocol", "").split(",")]
        return next((name for name in (PROTOCOL, LEGACY_PROTOCOL) if name in names), None)


def parse_request(head: bytes) -> Request:
    """Parse a request's head, with or without the empty line at its end.

    Raises:
        BadRequest: It cannot open a WebSocket.
    """
    if len(head) > MAX_HEAD_BYTES:
        raise BadRequest(431, f"the request's head is longer than {MAX_HEAD_BYTES} bytes")
    lines = head.decode("latin-1").removesuffix("\r\n\r\n").split("\r\n")
    words = lines[0].split(" ")
    if len(words) != 3 or not words[2].startswith("HTTP/1."):
        raise BadRequest(400, "this is no HTTP/1.1 request")
    headers: dict[str, str] = {}
    for line in lines[1:]:
        name, colon, value = line.partition(":")
        if not colon or not name or name != name.strip() or any(ord(c) < 32 and c != "\t" for c in value):
            raise BadRequest(400, "a line of the request's head is no header")
        name, value = name.lower(), value.strip()
        headers[name] = f"{headers[name]}, {value}" if name in headers else value
    if words[0] != "GET":
        raise BadRequest(405, "only GET opens a WebSocket")
    return Request(words[1], headers)


def check_request(request: Request, *, bound: str, origins: Sequence[str], token: str | None) -> str:
    """Check that a client may connect; returns the name under which it speaks the protocol.

    Args:
        request: The client's.
        bound: The address we listen on.
        origins: Origins of web pages that may connect.
        token: The token that the client has to send; None if there is none.

    Raises:
        BadRequest: It may not connect. The answer tells it no more than that.
    """
    for refusal in (
        foreign_host(request.headers.get("host"), bound),
        foreign_origin(request.headers.get("origin"), origins),
    ):
        if refusal is not None:
            raise BadRequest(403, refusal)
    if not token_fits(request.token, token):
        raise BadRequest(401, "the token is missing or wrong: add ?token=... to the address")
    upgrade = request.headers.get("upgrade", "").lower()
    if upgrade != "websocket" or not request.headers.get("sec-websocket-key"):
        raise BadRequest(
            426, "this is a Foxglove server: open its address (ws://...) in Foxglove or Lichtblick"
        )
    protocol = request.protocol
    if protocol is None:
        raise BadRequest(400, f"the client speaks neither {PROTOCOL} nor {LEGACY_PROTOCOL}")
    return protocol


def upstream_request(request: Request, port: int) -> bytes:
    """The request as it goes to the SDK's server: the headers it needs, without token and extensions."""
    return (
        "GET / HTTP/1.1\r\n"
        f"Host: 127.0.0.1:{port}\r\n"
        "Upgrade: websocket\r\n"
        "Connection: Upgrade\r\n"
        f"Sec-WebSocket-Key: {request.headers['sec-websocket-key']}\r\n"
        f"Sec-WebSocket-Version: {request.headers.get('sec-websocket-version', '13')}\r\n"
        f"Sec-WebSocket-Protocol: {PROTOCOL}\r\n\r\n"
    ).encode("latin-1")


def text_frame(text: str) -> bytes:
    """A short text as a client's frame (RFC 6455, 5.2), masked with zeros: it stays on this computer."""
    data = text.encode("utf-8")
    if len(data) < 126:
        return bytes((0x81, 0x80 | len(data), 0, 0, 0, 0)) + data
    return bytes((0x81, 0x80 | 126)) + len(data).to_bytes(2, "big") + bytes(4) + data


def client_response(head: bytes, protocol: str) -> bytes:
    """The SDK's answer as the client gets it, with the protocol's name that the client offered.

    Raises:
        BadRequest: The SDK refused the request.
    """
    first, *lines = head.decode("latin-1").removesuffix("\r\n\r\n").split("\r\n")
    if first.split(" ")[1:2] != ["101"]:
        raise BadRequest(400, "the request opens no WebSocket")
    kept = [line for line in lines if line.partition(":")[0].strip().lower() != "sec-websocket-protocol"]
    return "\r\n".join([first, *kept, f"Sec-WebSocket-Protocol: {protocol}", "", ""]).encode("latin-1")


def error_response(problem: BadRequest) -> bytes:
    """The HTTP response that refuses a request."""
    body = f"{problem.text}\n".encode("utf-8", "replace")
    extra = "WWW-Authenticate: Bearer\r\n" if problem.status == 401 else ""
    return (
        f"HTTP/1.1 {problem.status} {_REASONS[problem.status]}\r\n"
        f"Content-Type: text/plain; charset=utf-8\r\nContent-Length: {len(body)}\r\n{extra}"
        "Connection: close\r\n\r\n"
    ).encode("latin-1") + body
