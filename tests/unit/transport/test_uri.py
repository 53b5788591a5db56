"""Hosts, ports and URIs."""

from __future__ import annotations

import errno
import socket
import threading

import pytest

from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.transport import uri as address
from rosproto.transport.deadline import Deadline


@pytest.mark.parametrize(
    ("uri", "host", "port"),
    [
        ("http://10.0.0.7:11311/", "10.0.0.7", 11311),
        ("http://10.0.0.7:11311", "10.0.0.7", 11311),
        ("http://10.0.0.7/", "10.0.0.7", 80),
        ("http://10.0.0.7", "10.0.0.7", 80),
        ("http://10.0.0.7:/", "10.0.0.7", 80),
        ("http://robot:11311/path/x?y#z", "robot", 11311),
        ("http://robot:11311?query", "robot", 11311),
        ("HTTP://Robot.Local:11311/", "robot.local", 11311),
        ("  http://robot:1/\n", "robot", 1),
        ("robot:11311", "robot", 11311),
        ("robot", "robot", 80),
        ("rosrpc://robot:40001", "robot", 40001),
        ("http://[::1]:11311/", "::1", 11311),
        ("http://[fe80::1%eth0]/", "fe80::1%eth0", 80),
        ("http://r:0/", "r", 0),
        ("http://r:65535/", "r", 65535),
        ("http://r:1/http://x:2/", "r", 1),
        ("", "localhost", 11311),
    ],
)
def test_every_form_of_a_uri_is_read(uri: str, host: str, port: int) -> None:
    assert address.parse_uri(uri) == (host, port)


@pytest.mark.parametrize(
    "uri",
    [
        "http://",
        "http:///x",
        "http://:1/",
        "http://r:x/",
        "http://r:65536/",
        "http://r:-1/",
        "http://r:١/",
        "http://::1:11311/",
        "http://[::1/",
        "http://[::1]x/",
        "http://a b/",
        "http://user@host/",
        "http://r:999999999/",
    ],
)
def test_what_is_no_uri_is_a_value_error_that_shows_it(uri: str) -> None:
    with pytest.raises(ValueError, match="URI"):
        address.parse_uri(uri)


def test_uris_are_made_with_a_trailing_slash_and_brackets() -> None:
    assert address.make_uri("10.0.0.7", 1) == "http://10.0.0.7:1/"
    assert address.make_uri("::1", 2) == "http://[::1]:2/"
    assert address.make_uri("h", 3, "rosrpc") == "rosrpc://h:3/"
    for host in ("10.0.0.7", "::1"):
        assert address.parse_uri(address.make_uri(host, 5)) == (host, 5)


@pytest.mark.parametrize(
    ("uri", "path"),
    [("http://h:1/", "/"), ("http://h:1", "/"), ("http://h:1/RPC2", "/RPC2"), ("h:1/x", "/x"), ("", "/")],
)
def test_the_path_of_a_uri(uri: str, path: str) -> None:
    assert address.uri_path(uri) == path


@pytest.mark.promise("URIs are the same in another case or")
def test_equal_uris_differ_in_case_slash_and_path_only() -> None:
    assert address.same_uri("http://Robot:1/", "http://robot:1")
    assert address.same_uri("http://robot/", "http://robot:80")
    assert not address.same_uri("http://robot:1/", "http://robot:2/")
    assert not address.same_uri("http://robot:1/", "nonsense:x")
    assert address.same_uri("nonsense:x", "nonsense:x")


@pytest.mark.parametrize(
    ("host", "yes"),
    [
        ("localhost", True),
        ("LOCALHOST", True),
        ("127.0.0.1", True),
        ("127.9.9.9", True),
        ("::1", True),
        ("[::1]", True),
        ("::ffff:127.0.0.1", True),
        ("10.0.0.7", False),
        ("127.example.com", False),
        ("::", False),
    ],
)
def test_loopback_is_judged_by_the_text(host: str, yes: bool) -> None:
    assert address.is_loopback(host) is yes


@pytest.mark.promise("No name server is asked for the name")
def test_numeric_hosts_and_localhost_ask_no_name_server(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object) -> None:
        raise AssertionError("asked")

    monkeypatch.setattr(socket, "getaddrinfo", forbidden)
    assert address.resolve("10.0.0.7") == ["10.0.0.7"]
    assert address.resolve("[::1]") == ["::1"]
    assert address.resolve("LocalHost") == ["127.0.0.1", "::1"]


def test_names_give_ipv4_first_and_each_address_once(monkeypatch: pytest.MonkeyPatch) -> None:
    v4, v6 = (socket.AF_INET, 0, 0, "", ("10.0.0.7", 0)), (socket.AF_INET6, 0, 0, "", ("fd00::7", 0, 0, 0))
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_: [v6, v4, v4])
    assert address.resolve("robot") == ["10.0.0.7", "fd00::7"]


@pytest.mark.parametrize(
    "error", [socket.gaierror(-2, "Name or service not known"), UnicodeError("label too long")]
)
def test_an_unknown_name_says_what_to_do(monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(socket, "getaddrinfo", fail)
    with pytest.raises(ConnectionLost, match=r"'robot'.*hosts file.*ROS_HOSTNAME") as caught:
        address.resolve("robot")
    assert caught.value.__cause__ is error


def test_a_silent_name_server_costs_the_deadline_only(monkeypatch: pytest.MonkeyPatch) -> None:
    release = threading.Event()
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_: release.wait(10) and [])
    try:
        with pytest.raises(RosTimeout, match="'silent-robot'"):  # a name of its own: lookups are shared
            address.resolve("silent-robot", Deadline(0.02))
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
                address.resolve("slow-robot", Deadline(0.01))
        assert asked == ["slow-robot"]
    finally:
        release.set()
    assert address.resolve("slow-robot", Deadline(10)) == ["10.0.0.7"]


def test_the_address_towards_a_loopback_peer_is_loopback() -> None:
    assert address.local_address_towards("127.0.0.1", 11311) == "127.0.0.1"
    assert address.local_address_towards("localhost", 0) == "127.0.0.1"


def test_no_route_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    class NoRoute(socket.socket):
        def connect(self, _address: object) -> None:
            raise OSError(errno.ENETUNREACH, "Network is unreachable")

    monkeypatch.setattr(socket, "socket", NoRoute)
    with pytest.raises(ConnectionLost, match="no route"):
        address.local_address_towards("10.0.0.7", 11311)


@pytest.mark.promise("`ROS_HOSTNAME` goes before `ROS_IP`")
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
    assert address.host_from_environment(environment, specials) == host


@pytest.mark.parametrize("value", ["http://me", "me:11311", "a/b"])
def test_a_host_that_is_a_uri_is_refused(value: str) -> None:
    with pytest.raises(ValueError, match="ROS_HOSTNAME"):
        address.host_from_environment({"ROS_HOSTNAME": value})


@pytest.mark.parametrize(
    ("host", "why"),
    [
        ("169.254.128.300", "300 is more than 255"),
        ("999.1.1.1", "999 is more than 255"),
        ("10.0.0.7.1", "it has 5 numbers, and an address has 4"),
        ("1.2.3." + "9" * 4000, "is more than 255"),
    ],
)
def test_numbers_that_are_no_address_ask_no_name_server(
    host: str, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not "cannot be resolved; add it to the hosts file": it is mistyped."""
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_: pytest.fail("the name server was asked"))
    with pytest.raises(ConnectionLost, match="is not a valid IPv4 address") as caught:
        address.resolve(host)
    assert why in str(caught.value)
    assert len(str(caught.value)) < 250
