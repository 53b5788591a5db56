"""UDP sockets for UDPROS: one to receive on, one to send from."""

from __future__ import annotations

import socket

from rosproto.transport.deadline import Deadline
from rosproto.transport.name_lookup import resolve
from rosproto.transport.os_errors import system_errors, translate
from rosproto.transport.uri import format_address

BUFFER_BYTES = 2 << 20  # requested; systems may give less. A picture is a thousand datagrams in a burst


def open_receiver(host: str) -> socket.socket:
    """Return a socket that receives datagrams on this address of ours, on a free port.

    Raises:
        ConnectionLost: It is not an address of this computer.
    """
    address = resolve(host)[0]
    sock = _socket(address)
    try:
        sock.bind((address, 0))
        _widen(sock, socket.SO_RCVBUF)
    except OSError as error:
        sock.close()
        raise translate(error, f"wait for datagrams at {address}", address) from error
    return sock


def open_sender(host: str, port: int, deadline: Deadline) -> socket.socket:
    """Return a connected socket; the system then reports when nothing receives the datagrams.

    Raises:
        ConnectionLost: The host is unknown, or there is no route to it.
        RosTimeout: The name server does not answer.
    """
    peer = format_address(host, port)
    address = resolve(host, deadline)[0]
    sock = _socket(address)
    try:
        sock.connect((address, port))
        _widen(sock, socket.SO_SNDBUF)
    except OSError as error:
        sock.close()
        raise translate(error, f"send datagrams to {peer}", peer) from error
    return sock


def _socket(address: str) -> socket.socket:
    with system_errors("open a socket for datagrams", address):
        return socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_DGRAM)


def _widen(sock: socket.socket, option: int) -> None:
    try:
        sock.setsockopt(socket.SOL_SOCKET, option, BUFFER_BYTES)
    except OSError:
        pass  # optional: some systems refuse a large buffer instead of giving a smaller one
