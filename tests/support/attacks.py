"""Raw sockets for tests that misbehave on purpose."""

from __future__ import annotations

import socket
import struct
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rosproto.protocol.handshake import decode_header, encode_header
from tests.support.load import crowd

__all__ = [
    "connect",
    "ended_by_peer",
    "http_post",
    "many",
    "read_frame",
    "read_http",
    "reset",
    "service_header",
    "subscriber_header",
]

_LINGER_RESET = struct.pack("hh" if sys.platform == "win32" else "ii", 1, 0)
STRING_MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"
SETBOOL_MD5 = "09fb03525b03e7ea1fd3992bafd87e16"


def connect(address: tuple[str, int], data: bytes = b"", source: str = "") -> socket.socket:
    """Connect with a time-out, and send `data`; `source` is the local address."""
    sock = socket.create_connection(address, 60, source_address=(source, 0) if source else None)
    if data:
        sock.sendall(data)
    return sock


def reset(sock: socket.socket) -> None:
    """End a connection with RST."""
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _LINGER_RESET)
    sock.close()


@contextmanager
def many(address: tuple[str, int], count: int, data: bytes = b"") -> Iterator[list[socket.socket]]:
    """Open `count` connections at once; refused ones count, too."""
    sockets: list[socket.socket] = []
    try:
        for _ in range(count):
            try:
                sockets.append(connect(address, data))
            except OSError:
                pass  # refused or reset: that is an answer to a flood
        yield sockets
    finally:
        for sock in sockets:
            sock.close()


def ended_by_peer(sock: socket.socket, within: float) -> bool:
    """Whether the peer ends the connection in time, after any data; a busy computer has more time."""
    end = time.monotonic() + within * crowd()
    while (left := end - time.monotonic()) > 0:
        sock.settimeout(left)
        try:
            if not sock.recv(65536):
                return True
        except TimeoutError:
            return False
        except OSError:
            return True
    return False


def read_exactly(sock: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        part = sock.recv(size - len(data))
        assert part, f"the connection ended after {len(data)} of {size} bytes"
        data += part
    return data


def read_frame(sock: socket.socket) -> bytes:
    """A TCPROS frame."""
    return read_exactly(sock, struct.unpack("<I", read_exactly(sock, 4))[0])


def read_header(sock: socket.socket) -> dict[str, str]:
    """A connection header."""
    return decode_header(read_frame(sock))


def subscriber_header(topic: str, **fields: str) -> bytes:
    """A subscriber of std_msgs/String, fields changed or ("") left out."""
    all_fields = {"topic": topic, "type": "std_msgs/String", "md5sum": STRING_MD5, "callerid": "/attacker"}
    return encode_header({key: value for key, value in {**all_fields, **fields}.items() if value})


def service_header(service: str = "/echo", **fields: str) -> bytes:
    """A client of std_srvs/SetBool, fields changed or ("") left out."""
    all_fields = {"service": service, "md5sum": SETBOOL_MD5, "callerid": "/attacker"}
    return encode_header({key: value for key, value in {**all_fields, **fields}.items() if value})


def http_post(body: bytes, *, path: str = "/RPC2", extra: str = "", length: int | None = None) -> bytes:
    """A POST as roscpp makes it."""
    size = len(body) if length is None else length
    head = f"POST {path} HTTP/1.1\r\nUser-Agent: x\r\nHost: h\r\nContent-Type: text/xml\r\n{extra}"
    return head.encode() + f"Content-length: {size}\r\n\r\n".encode() + body


def read_http(sock: socket.socket) -> tuple[bytes, bytes]:
    """One HTTP answer: (head, body)."""
    data = b""
    while b"\r\n\r\n" not in data:
        part = sock.recv(65536)
        assert part, f"no answer, only {data[:200]!r}"
        data += part
    head, _, body = data.partition(b"\r\n\r\n")
    for line in head.split(b"\r\n"):
        if line.lower().startswith(b"content-length:"):
            size = int(line.split(b":")[1])
            return head, body + read_exactly(sock, size - len(body))
    return head, body
