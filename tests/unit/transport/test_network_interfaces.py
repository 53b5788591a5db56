"""The addresses of this computer's network interfaces."""

from __future__ import annotations

import os
import socket

import pytest

from rosproto.transport import network_interfaces
from rosproto.transport.network_interfaces import interface_addresses


@pytest.mark.parametrize("family", [socket.AF_INET, socket.AF_INET6])
def test_every_address_can_be_bound_and_is_told_once(family: socket.AddressFamily) -> None:
    """They are this computer's own: a server can listen there."""
    found = interface_addresses(family)
    assert len(found) == len(set(found))
    for address in found:
        place = socket.getaddrinfo(address, 0, family, socket.SOCK_STREAM, 0, socket.AI_NUMERICHOST)[0][4]
        with socket.socket(family, socket.SOCK_STREAM) as sock:
            sock.bind(place)


def test_the_loopback_and_the_card_are_among_them() -> None:
    """The card's address is the one that a connection to the outside would come from; none is made."""
    found = interface_addresses()
    assert "127.0.0.1" in found
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        try:
            sock.connect(("192.0.2.1", 9))  # sends nothing; TEST-NET-1, RFC 5737
        except OSError:
            return  # no card is up
        assert sock.getsockname()[0] in found


def test_without_the_systems_function_the_computers_name_is_resolved(monkeypatch: pytest.MonkeyPatch) -> None:
    """An old C library: what the resolver says, and the loopback."""

    def none(family: socket.AddressFamily) -> list[str]:
        raise AttributeError("getifaddrs")

    monkeypatch.setattr(network_interfaces, "_posix" if os.name == "posix" else "_windows", none)
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_: [(0, 0, 0, "", ("10.0.0.7", 0))])
    assert interface_addresses() == ["10.0.0.7", "127.0.0.1"]
