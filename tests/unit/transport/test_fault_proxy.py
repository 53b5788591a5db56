"""The fault-injecting proxy that other tests use."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator

import pytest

from rosproto.transport.tcp_server import TcpServer
from tests.support import attacks
from tests.support.marks import needs_rst
from tests.support.proxy import FaultProxy
from tests.support.waiting import until

SOON = 20.0


def echo(sock: socket.socket, _peer: object) -> None:
    while data := sock.recv(1000):
        sock.sendall(data)


@pytest.fixture
def proxy() -> Iterator[FaultProxy]:
    with TcpServer("127.0.0.1", 0, echo) as server, FaultProxy("127.0.0.1", server.port) as running:
        yield running


@pytest.fixture
def client(proxy: FaultProxy) -> Iterator[socket.socket]:
    with socket.create_connection((proxy.host, proxy.port), SOON) as sock:
        sock.sendall(b"hello")
        assert attacks.read_exactly(sock, 5) == b"hello"
        yield sock


def test_bytes_go_both_ways(proxy: FaultProxy, client: socket.socket) -> None:
    assert (proxy.accepted, proxy.connections) == (1, 1)
    assert proxy.forwarded >= 5


def test_cut_ends_with_fin_and_new_connections_work(proxy: FaultProxy, client: socket.socket) -> None:
    proxy.cut()
    assert client.recv(1) == b""
    assert proxy.connections == 0
    with socket.create_connection((proxy.host, proxy.port), SOON) as other:
        other.sendall(b"x")
        assert other.recv(1) == b"x"


@needs_rst
def test_reset_ends_with_rst(proxy: FaultProxy, client: socket.socket) -> None:
    proxy.reset()
    with pytest.raises(ConnectionResetError):
        client.recv(1)


def test_stall_holds_bytes_until_resume(proxy: FaultProxy, client: socket.socket) -> None:
    proxy.stall()
    client.sendall(b"later")
    client.settimeout(0.05)
    with pytest.raises(TimeoutError):
        client.recv(1)
    proxy.resume()
    client.settimeout(SOON)
    assert attacks.read_exactly(client, 5) == b"later"


def test_cut_after_lets_so_many_bytes_through(proxy: FaultProxy, client: socket.socket) -> None:
    seen: list[bytes] = []
    got = threading.Event()

    def keep(sock: socket.socket, _peer: object) -> None:
        while data := sock.recv(1000):
            seen.append(data)
        got.set()

    with TcpServer("127.0.0.1", 0, keep) as server:
        proxy.retarget("127.0.0.1", server.port)
        with socket.create_connection((proxy.host, proxy.port), SOON) as other:
            until(lambda: proxy.connections == 2, SOON, "the other connection")
            proxy.cut_after(3)
            other.sendall(b"abcdef")
            assert got.wait(SOON)
            assert b"".join(seen) == b"abc"


def test_one_byte_at_a_time_and_delayed(proxy: FaultProxy, client: socket.socket) -> None:
    proxy.byte_at_a_time = True
    proxy.delay(0.01)
    client.sendall(b"abc")
    assert attacks.read_exactly(client, 3) == b"abc"


def test_refusing_closes_new_connections(proxy: FaultProxy) -> None:
    proxy.refusing = True
    with socket.create_connection((proxy.host, proxy.port), SOON) as sock:
        assert sock.recv(1) == b""


@needs_rst
def test_an_absent_target_resets_the_client(proxy: FaultProxy) -> None:
    with TcpServer("127.0.0.1", 0, echo) as gone:
        pass
    proxy.retarget("127.0.0.1", gone.port)
    with (
        pytest.raises(ConnectionResetError),  # already connecting may meet it
        socket.create_connection((proxy.host, proxy.port), SOON) as sock,
    ):
        sock.recv(1)
