"""Exact reads and the connection header on a blocking socket, each under a deadline.

rospy's connect time-out ends with the connect, so that its handshake can hang for ever; here one deadline
covers both. The socket is blocking again when a function returns.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping
from struct import Struct

from rosproto.errors import ConnectionLost, TooLarge
from rosproto.protocol.header import decode_header, encode_header
from rosproto.protocol.limits import Limits
from rosproto.transport.address import format_address
from rosproto.transport.deadline import Deadline
from rosproto.transport.local_socket import name_of
from rosproto.transport.os_errors import closed_by_peer, translate

__all__ = ["ClosedBeforeHeader", "peer_name", "read_exactly", "read_header", "write_all", "write_header"]

_LENGTH = Struct("<I")
_STEP = 1 << 16  # memory follows the bytes that arrive, in steps of this


class ClosedBeforeHeader(ConnectionLost):
    """The peer connected and closed without a byte: somebody looked whether we are there. No error."""


def peer_name(sock: socket.socket) -> str:
    """ "host:port" of the other side, or "peer" when it is gone."""
    try:
        address = sock.getpeername()
        return name_of(address) or format_address(*address[:2])
    except (OSError, TypeError):
        return "peer"


def read_exactly(sock: socket.socket, size: int, deadline: Deadline, doing: str = "read") -> bytearray:
    """Read `size` bytes.

    Raises:
        ConnectionLost: The peer closed first.
        RosTimeout: The deadline passed.
    """
    data = bytearray()
    try:
        while len(data) < size:
            sock.settimeout(_time_left(deadline))
            chunk = sock.recv(min(_STEP, size - len(data)))
            if not chunk:
                error = closed_by_peer(f"{doing}, {len(data)} of {size} bytes", peer_name(sock))
                raise error if data else ClosedBeforeHeader(str(error), peer=error.peer)
            data += chunk
        sock.settimeout(None)
    except OSError as error:
        if isinstance(error, ConnectionLost):
            raise
        peer = peer_name(sock)
        raise translate(error, f"{doing} from {peer}", peer, deadline) from error
    return data


def write_all(sock: socket.socket, data: bytes | bytearray | memoryview, deadline: Deadline) -> None:
    """Write all bytes.

    Raises:
        ConnectionLost: The peer closed.
        RosTimeout: The peer did not take them before the deadline.
    """
    try:
        sock.settimeout(_time_left(deadline))
        sock.sendall(data)  # its time-out covers the whole call
        sock.settimeout(None)
    except OSError as error:
        peer = peer_name(sock)
        raise translate(error, f"write to {peer}", peer, deadline) from error


def read_header(sock: socket.socket, limits: Limits, deadline: Deadline) -> dict[str, str]:
    """Read one connection header; not a byte more, so that messages after it stay in the socket.

    Raises:
        ClosedBeforeHeader: The peer closed without a byte.
        ConnectionLost: The peer closed in between.
        RosTimeout: The deadline passed.
        TooLarge: `Limits.header_bytes`.
        RemoteProtocolError: These bytes are no header.
    """
    (size,) = _LENGTH.unpack(read_exactly(sock, 4, deadline, "read a connection header"))
    if size > limits.header_bytes:
        raise TooLarge("header_bytes", size, limits.header_bytes)
    try:
        body = read_exactly(sock, size, deadline, "read a connection header")
    except ClosedBeforeHeader as error:  # after its length, so it did begin
        raise ConnectionLost(str(error), peer=error.peer) from error
    return decode_header(body)


def write_header(sock: socket.socket, fields: Mapping[str, str], deadline: Deadline) -> None:
    """Write one connection header.

    Raises:
        LocalProtocolError: A field cannot be encoded.
        ConnectionLost: The peer closed.
        RosTimeout: The peer did not take it before the deadline.
    """
    write_all(sock, encode_header(fields), deadline)


def _time_left(deadline: Deadline) -> float | None:
    left = deadline.remaining()
    if left is not None and left <= 0:
        raise TimeoutError  # settimeout(0) would mean non-blocking
    return left
