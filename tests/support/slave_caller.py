"""Calls a node's slave API from an address of choice."""

from __future__ import annotations

import socket
from typing import Any

import pytest

from rosproto.protocol.xmlrpc import decode_response, encode_call
from tests.support import attacks

STRANGER = "127.0.0.9"  # an address that is not the master's


def require_second_address() -> None:
    """Linux has all of 127.0.0.0/8; elsewhere there may be no second address to call from."""
    try:
        socket.create_server((STRANGER, 0)).close()
    except OSError:
        pytest.skip(f"this computer has no address {STRANGER}")


class Caller:
    """One HTTP connection from an address of choice."""

    def __init__(self, address: tuple[str, int], source: str = STRANGER) -> None:
        self._sock = attacks.connect(address, source=source)

    def __enter__(self) -> Caller:
        return self

    def __exit__(self, *exc: object) -> None:
        self._sock.close()

    def call(self, method: str, *params: Any) -> Any:
        """The node's reply."""
        self._sock.sendall(attacks.http_post(encode_call(method, list(params))))
        return decode_response(attacks.read_http(self._sock)[1])
