"""The part of HTTP/1.1 that a POST needs, for both sides of a connection: bytes in, messages out.

Messages are written as roscpp's client expects them (XmlRpcClient.cpp): the status line exactly `HTTP/1.1 200
OK`, `Content-length: ` with one space, never chunked. The reader accepts more: HTTP/1.0, chunked bodies,
`Expect: 100-continue`, lines that end in a bare newline, pipelined requests.

`receive(b"")` reports that the peer has closed its side.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from typing import NamedTuple

from rosproto.errors import LocalProtocolError, RemoteProtocolError, TooLarge
from rosproto.protocol.wire_limits import Limits

CONTINUE = b"HTTP/1.1 100 Continue\r\n\r\n"
_CHUNK_LINE_BYTES = 256  # a chunk size, and extensions that are never used
_TOKEN = frozenset("!#$%&'*+-.^_`|~0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")


class HttpStatusError(RemoteProtocolError):
    """The peer's HTTP message is refused.

    Attributes:
        status: Status code that a server sends before it closes.
    """

    def __init__(self, status: int, message: str) -> None:
        super().__init__(f"HTTP: {message}")
        self.status = status


def error_status(error: RemoteProtocolError) -> int:
    """The status code with which a server replies to a request that raised this error."""
    if isinstance(error, TooLarge):
        return 431 if error.what == "http_head_bytes" else 413
    return error.status if isinstance(error, HttpStatusError) else 400


class Request(NamedTuple):
    """A complete request. `headers` has lower-case names; `keep_alive` is what the peer requests."""

    method: str
    target: str
    headers: dict[str, str]
    body: bytes
    keep_alive: bool = True


class Response(NamedTuple):
    """A complete response. `keep_alive`: the connection can be used again."""

    status: int
    reason: str
    headers: dict[str, str]
    body: bytes
    keep_alive: bool = True


class ContinueWanted:
    """The client waits before it sends the body: send `CONTINUE`."""

    __slots__ = ()


class PeerClosed:
    """The peer closed between two messages."""

    __slots__ = ()


Event = Request | Response | ContinueWanted | PeerClosed


@dataclass(slots=True)
class _Head:
    """A parsed head and the form of the body: a length, chunks, or (None) everything until the end."""

    start: list[str]
    headers: dict[str, str]
    version: str = ""
    length: int | None = 0
    chunked: bool = False


_BEGUN_ENDS = (b"\r\n\r", b"\r\n", b"\n\r", b"\r", b"\n")
"""Beginnings of the end of a head, the longest first."""


class _Connection:
    """Base of both sides: splits the stream into heads and bodies."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._buffer = bytearray()
        self._searched = 0  # the head does not end before this; keeps byte-by-byte input linear
        self._head: _Head | None = None
        self._body = bytearray()
        self._chunks: Iterator[bool] | None = None
        self._ended = False

    def receive(self, data: bytes | bytearray | memoryview) -> None:
        """Add bytes from the peer; empty bytes mean that it closed its side."""
        if len(data) == 0:
            self._ended = True
        elif self._ended:
            raise LocalProtocolError("HTTP: bytes after the end of the stream")
        self._buffer += data

    @property
    def mid_message(self) -> bool:
        """Whether part of a message has arrived."""
        return self._head is not None or bool(self._buffer)

    def _read_head(self) -> _Head | None:
        if self._head is None:
            text = self._cut_head()
            if text is not None:
                self._head = self._parse_head(text)
        return self._head

    def _cut_head(self) -> bytes | None:
        """The lines up to the first empty one; None before that has arrived."""
        buffer = self._buffer
        while buffer.startswith((b"\r\n", b"\n")):  # ignore empty lines before a message
            del buffer[: buffer.index(b"\n") + 1]
        start = max(0, self._searched - 3)
        ends = [
            (at, at + len(mark))
            for mark in (b"\r\n\r\n", b"\n\n", b"\n\r\n")
            if (at := buffer.find(mark, start)) >= 0
        ]
        if ends:
            size = min(ends)[0]
        else:  # a possible start of the empty line is not part of the head
            size = len(buffer) - next((len(mark) for mark in _BEGUN_ENDS if buffer.endswith(mark)), 0)
        if size > self._limits.http_head_bytes:
            raise TooLarge("http_head_bytes", size, self._limits.http_head_bytes)
        if not ends:
            self._searched = len(buffer)
            return None
        at, end = min(ends)
        head = bytes(buffer[:at])
        del buffer[:end]
        self._searched = 0
        return head

    def _parse_head(self, text: bytes) -> _Head:
        lines = [line.removesuffix("\r") for line in text.decode("latin-1").split("\n")]
        head = _Head(lines[0].split(None, 2), _parse_fields(lines[1:]))
        self._parse_start(head)
        self._parse_body_length(head)
        return head

    def _parse_start(self, head: _Head) -> None:
        """Parse the first line."""

    def _no_length(self, head: _Head) -> int | None:
        """Body length if the head gives none; None means until the end of the stream."""

    def _parse_body_length(self, head: _Head) -> None:
        coding, length = head.headers.get("transfer-encoding"), head.headers.get("content-length")
        if coding is not None:
            if coding.strip().lower() != "chunked":
                raise HttpStatusError(501, f"Transfer-Encoding {coding[:40]!r}, only chunked is known")
            if length is not None:
                raise HttpStatusError(400, "both Transfer-Encoding and Content-Length")
            head.chunked = True
        elif length is None:
            head.length = self._no_length(head)
        elif not (length.isascii() and length.isdigit() and len(length) <= 20):
            raise HttpStatusError(400, f"Content-Length {length[:40]!r} is not a number")
        else:
            head.length = int(length)
            self._check_body(head.length)

    def _check_body(self, size: int) -> None:
        if size > self._limits.xml_body_bytes:
            raise TooLarge("xml_body_bytes", size, self._limits.xml_body_bytes)

    def _read_body(self, head: _Head) -> bytes | None:
        """Take out the whole body; None while it is incomplete."""
        if head.chunked:
            self._chunks = self._chunks or self._read_chunks()
            complete = next(self._chunks, False)
        elif head.length is None:
            self._check_body(len(self._buffer))
            complete = self._ended
            if complete:
                self._move_to_body(len(self._buffer))
        else:
            complete = len(self._buffer) >= head.length
            if complete:
                self._move_to_body(head.length)
        if not complete:
            return None
        body = bytes(self._body)
        self._body.clear()
        self._head = self._chunks = None
        return body

    def _move_to_body(self, size: int) -> None:
        with memoryview(self._buffer) as view:
            self._body += view[:size]
        del self._buffer[:size]

    def _read_chunks(self) -> Iterator[bool]:
        """Move a chunked body out of the buffer; yields False while bytes are missing, and then True."""
        size = -1
        line: bytes | None = None
        while size:
            while (line := self._cut_line(_CHUNK_LINE_BYTES)) is None:
                yield False
            digits = line.partition(b";")[0].strip()
            if not digits or len(digits) > 16 or digits.strip(b"0123456789abcdefABCDEF"):
                raise HttpStatusError(400, f"chunk size {digits[:40]!r} is not a hexadecimal number")
            size = int(digits, 16)
            self._check_body(len(self._body) + size)
            if size:
                while len(self._buffer) < size + 2:
                    yield False
                self._move_to_body(size)
                if self._cut_line(2) != b"":
                    raise HttpStatusError(400, "a chunk is longer than its size says")
        trailer_bytes = 0
        while line:
            while (line := self._cut_line(self._limits.http_head_bytes)) is None:
                yield False
            trailer_bytes += len(line)
            if trailer_bytes > self._limits.http_head_bytes:
                raise TooLarge("http_head_bytes", trailer_bytes, self._limits.http_head_bytes)
        yield True

    def _cut_line(self, limit: int) -> bytes | None:
        end = self._buffer.find(b"\n", 0, limit + 2)
        if end < 0:
            if len(self._buffer) >= limit + 2:
                raise HttpStatusError(400, f"a line of more than {limit} bytes")
            return None
        line = bytes(self._buffer[:end]).removesuffix(b"\r")
        del self._buffer[: end + 1]
        return line

    def _check_end(self) -> PeerClosed | None:
        """Handle the end of the stream: closed between messages, or within one."""
        if not self._ended:
            return None
        if self.mid_message:
            raise RemoteProtocolError("HTTP: the peer closed in the middle of a message")
        return PeerClosed()


def _parse_fields(lines: list[str]) -> dict[str, str]:
    headers: dict[str, str] = {}
    for line in lines:
        name, colon, value = line.partition(":")
        if not colon or not name or not _TOKEN.issuperset(name):
            raise HttpStatusError(400, f"header line {line[:60]!r}, expected 'Name: value'")
        name, value = name.lower(), value.strip(" \t\r")
        if name in headers and headers[name] != value:
            if name == "content-length":
                raise HttpStatusError(400, "two different Content-Length")
            value = f"{headers[name]}, {value}"
        headers[name] = value
    return headers


def _without_host(target: str) -> str:
    """The path of "http://robot:11311/RPC2", as clients behind a proxy send it (RFC 9112, 3.2.2)."""
    scheme, mark, rest = target.partition("://")
    return "/" + rest.partition("/")[2] if mark and scheme.isalpha() else target


def _keeps_alive(headers: dict[str, str], version: str) -> bool:
    options = [option.strip().lower() for option in headers.get("connection", "").split(",")]
    return "keep-alive" in options if version == "HTTP/1.0" else "close" not in options


def _encode(start: str, headers: dict[str, str], body: bytes) -> bytes:
    lines = [start, *(f"{name}: {value}" for name, value in headers.items())]
    for line in lines:
        if "\r" in line or "\n" in line:
            raise LocalProtocolError(f"HTTP: line break in {line[:60]!r}")
    return "\r\n".join([*lines, "", ""]).encode("latin-1", "replace") + body


class HttpServerConnection(_Connection):
    """The server's side: `next_event` returns requests, `encode_response` writes responses."""

    def __init__(self, limits: Limits) -> None:
        super().__init__(limits)
        self._continue_answered = False

    def next_event(self) -> Event | None:
        """The next event, or None until more bytes are received.

        Raises:
            RemoteProtocolError: The request is refused: reply with `error_status(error)`, then close. (A
                client that closes in the middle of a request gets no reply.)
        """
        head = self._read_head()
        if head is None:
            return self._check_end()
        body = self._read_body(head)
        if body is None:
            return self._check_expectation(head) or self._check_end()
        self._continue_answered = False
        method, target, _ = head.start
        return Request(
            method, _without_host(target), head.headers, body, _keeps_alive(head.headers, head.version)
        )

    def encode_response(
        self,
        status: int,
        body: bytes = b"",
        *,
        keep_alive: bool = True,
        allow: str = "",
        kind: str = "text/xml",
    ) -> bytes:
        """A response with its head. `allow` names the methods that a 405 response must list."""
        # roscpp requires this spelling of Content-length, and "200 OK"
        headers = {"Server": "rosproto", "Content-Type": kind, "Content-length": str(len(body))}
        if allow:
            headers["Allow"] = allow
        headers["Connection"] = "keep-alive" if keep_alive else "close"
        return _encode(f"HTTP/1.1 {status} {HTTPStatus(status).phrase}", headers, body)

    def _parse_start(self, head: _Head) -> None:
        if len(head.start) != 3 or not _TOKEN.issuperset(head.start[0]):
            raise HttpStatusError(400, f"request line {' '.join(head.start)[:60]!r}")
        head.version = head.start[2].strip()
        if head.version not in ("HTTP/1.1", "HTTP/1.0"):
            raise HttpStatusError(505, f"version {head.version[:20]!r}, expected HTTP/1.1")
        expectation = head.headers.get("expect", "100-continue")
        if expectation.lower() != "100-continue":
            raise HttpStatusError(417, f"Expect {expectation[:40]!r}")

    def _no_length(self, head: _Head) -> int | None:
        if head.start[0] in ("POST", "PUT", "PATCH"):
            raise HttpStatusError(411, f"{head.start[0]} without Content-Length")
        return 0

    def _check_expectation(self, head: _Head) -> ContinueWanted | None:
        if "expect" not in head.headers or self._continue_answered or self._ended:
            return None
        self._continue_answered = True
        return ContinueWanted()


XML: Mapping[str, str] = {"Content-Type": "text/xml"}


class HttpClientConnection(_Connection):
    """The client's side: `encode_request` writes requests, `next_event` returns responses."""

    def encode_request(self, host: str, path: str, body: bytes, more: Mapping[str, str] = XML) -> bytes:
        """A POST request with its head; `more` has the headers that differ between clients."""
        headers = {"Host": host, "User-Agent": "rosproto", **more, "Content-length": str(len(body))}
        return _encode(f"POST {path} HTTP/1.1", headers, body)

    def next_event(self) -> Event | None:
        """The next event, or None until more bytes are received.

        Raises:
            RemoteProtocolError: The bytes are not an HTTP response, or it was cut off.
        """
        while True:
            head = self._read_head()
            if head is None:
                return self._check_end()
            until_end = head.length is None and not head.chunked
            body = self._read_body(head)
            if body is None:
                return self._check_end()
            status = int(head.start[1])
            if status >= 200:  # 1xx are interim responses
                break
        reason = head.start[2] if len(head.start) > 2 else ""
        keep = not until_end and not self._ended and _keeps_alive(head.headers, head.version)
        return Response(status, reason, head.headers, body, keep)

    def _parse_start(self, head: _Head) -> None:
        start = head.start
        if len(start) < 2 or start[0] not in ("HTTP/1.1", "HTTP/1.0") or len(start[1]) != 3:
            raise HttpStatusError(400, f"status line {' '.join(start)[:60]!r}, expected HTTP/1.1 200 OK")
        if not (start[1].isascii() and start[1].isdigit()):
            raise HttpStatusError(400, f"status {start[1]!r} is not a number")
        head.version = start[0]

    def _no_length(self, head: _Head) -> int | None:
        status = int(head.start[1])
        return 0 if status < 200 or status in (204, 304) else None
