"""Looking up host names."""

from __future__ import annotations

import socket
import threading

import pytest

from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.transport.deadline import Deadline
from rosproto.transport.name_lookup import resolve


@pytest.mark.promise("No name server is asked for the name")
def test_numeric_hosts_and_localhost_ask_no_name_server(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object) -> None:
        raise AssertionError("asked")

    monkeypatch.setattr(socket, "getaddrinfo", forbidden)
    assert resolve("10.0.0.7") == ["10.0.0.7"]
    assert resolve("[::1]") == ["::1"]
    assert resolve("LocalHost") == ["127.0.0.1", "::1"]


def test_names_give_ipv4_first_and_each_address_once(monkeypatch: pytest.MonkeyPatch) -> None:
    v4, v6 = (socket.AF_INET, 0, 0, "", ("10.0.0.7", 0)), (socket.AF_INET6, 0, 0, "", ("fd00::7", 0, 0, 0))
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_: [v6, v4, v4])
    assert resolve("robot") == ["10.0.0.7", "fd00::7"]


@pytest.mark.parametrize(
    "error", [socket.gaierror(-2, "Name or service not known"), UnicodeError("label too long")]
)
def test_an_unknown_name_says_what_to_do(monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(socket, "getaddrinfo", fail)
    with pytest.raises(ConnectionLost, match=r"'robot'.*hosts file.*ROS_HOSTNAME") as caught:
        resolve("robot")
    assert caught.value.__cause__ is error


def test_a_silent_name_server_costs_the_deadline_only(monkeypatch: pytest.MonkeyPatch) -> None:
    release = threading.Event()
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_: release.wait(10) and [])
    try:
        with pytest.raises(RosTimeout, match="'silent-robot'"):  # a name of its own: lookups are shared
            resolve("silent-robot", Deadline(0.02))
    finally:
        release.set()


def test_links_that_ask_for_the_same_name_share_one_lookup(monkeypatch: pytest.MonkeyPatch) -> None:
    release, asked = threading.Event(), []

    def slow(*arguments: object) -> list[object]:
        asked.append(arguments[0])
        release.wait(10)
        return [(socket.AF_INET, 0, 0, "", ("10.0.0.7", 0))]

    monkeypatch.setattr(socket, "getaddrinfo", slow)
    try:
        for _ in range(3):
            with pytest.raises(RosTimeout):
                resolve("slow-robot", Deadline(0.01))
        assert asked == ["slow-robot"]
    finally:
        release.set()
    assert resolve("slow-robot", Deadline(10)) == ["10.0.0.7"]


@pytest.mark.parametrize(
    ("host", "why"),
    [
        ("169.254.128.300", "300 is more than 255"),
        ("999.1.1.1", "999 is more than 255"),
        ("10.0.0.7.1", "expected 4 numbers, got 5"),
        ("1.2.3." + "9" * 4000, "is more than 255"),
    ],
)
def test_numbers_that_are_no_address_ask_no_name_server(
    host: str, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not "cannot be resolved; add it to the hosts file": it is mistyped."""
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_: pytest.fail("the name server was asked"))
    with pytest.raises(ConnectionLost, match="is not a valid IPv4 address") as caught:
        resolve(host)
    assert why in str(caught.value)
    assert len(str(caught.value)) < 250
