"""Host names given by the user, and unknown ones, for which the master's host is assumed."""

from __future__ import annotations

import logging
import socket
import sys
import threading

import pytest

from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.transport import Deadline, HostNames, XmlRpcClient, connect, parse_host_names, robot_host_names
from rosproto.transport.robot_host_names import hosts_advice


@pytest.fixture(autouse=True)
def system(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The system knows `known` only; what it was asked."""
    asked: list[str] = []

    def look_up(host: str, *_: object) -> list[tuple[object, ...]]:
        asked.append(host)
        if host == "known":
            return [(socket.AF_INET, socket.SOCK_STREAM, 6, "", ("10.0.0.9", 0))]
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", look_up)
    return asked


def test_a_given_name_asks_nobody(system: list[str]) -> None:
    hosts = HostNames({"Robot-7": "10.0.0.7"}, master="10.0.0.1")
    assert hosts.resolve("robot-7") == ["10.0.0.7"]
    assert hosts.mapped("ROBOT-7") == "10.0.0.7"
    assert system == []
    assert hosts.unknown == []


def test_a_known_name_is_what_the_system_says() -> None:
    assert HostNames(master="10.0.0.1").resolve("known") == ["10.0.0.9"]


@pytest.mark.promise("For a name that cannot be resolved, the master's host is used")
def test_an_unknown_name_is_taken_for_the_masters_host_and_told_once(
    system: list[str], caplog: pytest.LogCaptureFixture
) -> None:
    hosts = HostNames(master="10.0.0.1")
    with caplog.at_level(logging.WARNING, "rosproto"):
        for _ in range(3):
            assert hosts.resolve("robot-xyz") == ["10.0.0.1"]
    assert system == ["robot-xyz"]  # it is not looked up with each link
    assert hosts.unknown == ["robot-xyz"]
    told = [record.getMessage() for record in caplog.records]
    assert len(told) == 1
    assert "--resolve robot-xyz=ADDRESS" in told[0]


@pytest.mark.promise("64 such names are remembered, each with a warning")
def test_what_peers_announce_is_bounded(caplog: pytest.LogCaptureFixture) -> None:
    """Neither memory nor the log grows with their names, and none of them reaches a terminal as it is."""
    hosts = HostNames(master="10.0.0.1")
    with caplog.at_level(logging.WARNING, "rosproto"):
        for number in range(3 * robot_host_names.MAX_NAMES):
            hosts.resolve(f"name-{number}")
    assert len(hosts.unknown) == robot_host_names.MAX_NAMES
    assert len(caplog.records) == robot_host_names.MAX_NAMES
    assert f"name-{3 * robot_host_names.MAX_NAMES - 1}" in hosts.unknown
    with pytest.raises(ConnectionLost) as caught:
        hosts.resolve("evil\x1b[31m")
    assert "\x1b" not in str(caught.value)


def test_an_unknown_name_is_looked_up_again_later(system: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_host_names, "RETRY_SECONDS", 0.0)
    hosts = HostNames(master="10.0.0.1")
    hosts.resolve("robot-xyz")
    hosts.resolve("robot-xyz")
    assert system == ["robot-xyz"] * 2


def test_a_name_server_that_keeps_silent_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    release = threading.Event()
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_: release.wait(10) and [])
    monkeypatch.setattr(robot_host_names, "LOOKUP_SECONDS", 0.02)
    try:
        assert HostNames(master="10.0.0.1").resolve("silent") == ["10.0.0.1"]
        with pytest.raises(RosTimeout):
            HostNames(master="10.0.0.1").resolve("silent", Deadline(0.0))
    finally:
        release.set()


def test_the_masters_own_name_and_a_master_that_is_not_given_are_not_guessed() -> None:
    for hosts in (HostNames(master="robot-xyz"), HostNames()):
        with pytest.raises(ConnectionLost, match="cannot be resolved"):
            hosts.resolve("robot-xyz")
    assert HostNames({"robot": "10.0.0.1"}, master="robot").resolve("other") == ["10.0.0.1"]


def test_connecting_goes_there_and_says_why_when_nobody_answers() -> None:
    hosts = HostNames(master="127.0.0.1")
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        connect("robot-xyz", port, Deadline(5.0), hosts=hosts).close()
    with pytest.raises(
        ConnectionLost, match=r"robot-xyz.*cannot be resolved here, so the master's address"
    ) as caught:
        connect("robot-xyz", port, Deadline(5.0), hosts=hosts)
    assert "--resolve robot-xyz=ADDRESS" in str(caught.value)
    with pytest.raises(ConnectionLost) as plain:
        connect("127.0.0.1", port, Deadline(5.0), hosts=hosts)
    assert "resolve" not in str(plain.value)


def test_a_client_of_xml_rpc_uses_them() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with (
            XmlRpcClient(
                f"http://robot-xyz:{port}/", timeout=0.2, hosts=HostNames({"robot-xyz": "127.0.0.1"})
            ) as client,
            pytest.raises(RosTimeout),
        ):
            client.call("getPid")
        server.settimeout(10.0)
        try:
            server.accept()[0].close()
        except TimeoutError:
            raise
        except OSError:
            pass  # Windows: it came, and was reset since


@pytest.mark.parametrize(
    ("texts", "found"),
    [
        ([], {}),
        ([""], {}),
        (["a=10.0.0.1"], {"a": "10.0.0.1"}),
        (
            ["a=10.0.0.1,b=10.0.0.2 c=[::1]", "d=other"],
            {"a": "10.0.0.1", "b": "10.0.0.2", "c": "::1", "d": "other"},
        ),
    ],
)
def test_how_they_are_written(texts: list[str], found: dict[str, str]) -> None:
    assert parse_host_names(texts) == found


@pytest.mark.parametrize(
    "text", ["robot", "=10.0.0.1", "robot=", "robot=http://10.0.0.1/", "robot=10.0.0.1:11311"]
)
def test_what_is_no_name_and_address_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="expected something like"):
        parse_host_names([text])


def test_the_advice_has_the_line_and_the_file_of_this_system(monkeypatch: pytest.MonkeyPatch) -> None:
    for platform in ("linux", "darwin"):
        monkeypatch.setattr(sys, "platform", platform)
        assert 'the line "10.0.0.7 robot-xyz" to /etc/hosts (with sudo)' in hosts_advice(
            "robot-xyz", "10.0.0.7"
        )
    monkeypatch.setattr(sys, "platform", "win32")
    said = hosts_advice("robot-xyz", "10.0.0.7")
    assert (
        r'the line "10.0.0.7 robot-xyz" to C:\Windows\System32\drivers\etc\hosts (as administrator)' in said
    )
    assert "--resolve robot-xyz=10.0.0.7" in said
    assert "ADDRESS is that of the computer that calls itself robot-xyz" in hosts_advice("robot-xyz", None)
