"""Read and write the connection header on a blocking socket within a deadline, and write whole buffers.

In rospy the connect time-out does not cover the handshake, which can hang for ever; here one deadline covers
both. The socket is blocking again when a function with a deadline returns.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping
from struct import unpack

from rosproto.errors import ConnectionLost, TooLarge
from rosproto.protocol.connection_header import decode_header, encode_header
from rosproto.protocol.wire_limits import Limits
from rosproto.sentence import led
from rosproto.transport.deadline import Deadline
from rosproto.transport.os_errors import translate
from rosproto.transport.uri import format_address

_PIECE = 64 << 10  # bytes; memory grows with what has arrived, not with the announced length


class ClosedBeforeHeader(ConnectionLost):
    """The peer connected and closed without sending a byte, as port probes do; not a failure."""


def peer_name(sock: socket.socket) -> str:
    """ "host:port" of the other side, or "peer" if it has gone."""
    try:
        return format_address(*sock.getpeername()[:2])
    except (OSError, TypeError):
        return "peer"


def write_all(sock: socket.socket, data: bytes | bytearray | memoryview, deadline: Deadline) -> None:
    """Write all bytes.

    Raises:
        ConnectionLost: The peer closed.
        RosTimeout: The peer did not accept them before the deadline.
    """
    try:
        sock.settimeout(deadline.for_socket())
        sock.sendall(data)  # its time-out covers the whole call
        sock.settimeout(None)
    except OSError as error:
        peer = peer_name(sock)
        raise translate(error, f"write to {peer}", peer, deadline) from error


def write_steadily(sock: socket.socket, data: bytes) -> None:
    """Write all bytes, however long it takes: the socket's time-out limits only the wait for the next piece.

    Raises:
        ConnectionLost: The peer closed.
        RosTimeout: The peer accepted nothing within the time-out.
    """
    try:
        sent = sock.send(data)
        while sent < len(data):
            sent += sock.send(memoryview(data)[sent:])
    except OSError as error:
        peer = peer_name(sock)
        raise translate(error, f"write to {peer}", peer) from error


def read_header(sock: socket.socket, limits: Limits, deadline: Deadline) -> dict[str, str]:
    """Read one connection header and nothing after it, so that messages stay in the socket.

    Raises:
        ClosedBeforeHeader: The peer closed without a byte.
        ConnectionLost: The peer closed in the middle.
        RosTimeout: The deadline passed.
        TooLarge: `Limits.header_bytes`.
        RemoteProtocolError: The bytes are not a header.
    """
    (size,) = unpack("<I", _read(sock, 4, 0, deadline))
    if size > limits.header_bytes:
        raise TooLarge("header_bytes", size, limits.header_bytes)
    return decode_header(_read(sock, size, 4, deadline))


def _read(sock: socket.socket, size: int, before: int, deadline: Deadline) -> bytearray:
    """Read `size` bytes of a header, of which `before` bytes were read already."""
    data = bytearray()
    try:
        while len(data) < size:
            sock.settimeout(deadline.for_socket())
            piece = sock.recv(min(size - len(data), _PIECE))
            if not piece:
                break
            data += piece
        sock.settimeout(None)
    except OSError as error:
        peer = peer_name(sock)
        raise translate(error, f"read a connection header from {peer}", peer, deadline) from error
    if len(data) < size:
        have = before + len(data)
        closed = "the connection was closed by the other side"
        raise (ConnectionLost if have else ClosedBeforeHeader)(
            led(f"read a connection header, after {have} bytes", closed), peer=peer_name(sock)
        )
    return data


def write_header(sock: socket.socket, fields: Mapping[str, str], deadline: Deadline) -> None:
    """Write one connection header.

    Raises:
        LocalProtocolError: A field cannot be encoded.
        ConnectionLost: The peer closed.
        RosTimeout: The peer did not accept it before the deadline.
    """
    write_all(sock, encode_header(fields), deadline)
