"""Choosing the address of this computer that peers can reach."""

from __future__ import annotations

import errno
import socket

import pytest

from rosproto.errors import ConnectionLost
from rosproto.transport.own_address import host_from_environment, local_address_towards


def test_the_address_towards_a_loopback_peer_is_loopback() -> None:
    assert local_address_towards("127.0.0.1", 11311) == "127.0.0.1"
    assert local_address_towards("localhost", 0) == "127.0.0.1"


def test_no_route_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    class NoRoute(socket.socket):
        def connect(self, _address: object) -> None:
            raise OSError(errno.ENETUNREACH, "Network is unreachable")

    monkeypatch.setattr(socket, "socket", NoRoute)
    with pytest.raises(ConnectionLost, match="no route"):
        local_address_towards("10.0.0.7", 11311)


@pytest.mark.promise("`ROS_HOSTNAME` takes precedence over `ROS_IP`")
@pytest.mark.parametrize(
    ("environment", "specials", "host"),
    [
        ({}, None, None),
        ({"ROS_HOSTNAME": "", "ROS_IP": " "}, {}, None),
        ({"ROS_IP": "10.0.0.1"}, {}, "10.0.0.1"),
        ({"ROS_IP": "10.0.0.1", "ROS_HOSTNAME": "me"}, {}, "me"),
        ({"ROS_HOSTNAME": "me"}, {"__ip": "10.0.0.2"}, "10.0.0.2"),
        ({"ROS_HOSTNAME": "me"}, {"__ip": "10.0.0.2", "__hostname": "arg"}, "arg"),
        ({"ROS_IP": "[::1]"}, None, "::1"),
        ({"ROS_IP": "::1"}, None, "::1"),
    ],
)
def test_the_order_of_the_environment(
    environment: dict[str, str], specials: dict[str, str] | None, host: str | None
) -> None:
    assert host_from_environment(environment, specials) == host


@pytest.mark.parametrize("value", ["http://me", "me:11311", "a/b"])
def test_a_host_that_is_a_uri_is_refused(value: str) -> None:
    with pytest.raises(ValueError, match="ROS_HOSTNAME"):
        host_from_environment({"ROS_HOSTNAME": value})
