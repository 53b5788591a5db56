"""The TCP server: limits, states of connections, closing."""

from __future__ import annotations

import errno
import logging
import queue
import socket
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto.protocol.wire_limits import Limits
from rosproto.transport import tcp_server
from rosproto.transport.tcp_server import TcpServer
from tests.support.clock import FakeClock
from tests.support.waiting import until

SOON = 20.0


class Holder:
    """A handler that keeps each connection until its peer closes; `seen` lists (sock, peer)."""

    def __init__(self) -> None:
        self.seen: list[tuple[socket.socket, tuple[str, int]]] = []
        self.arrived = threading.Semaphore(0)

    def __call__(self, sock: socket.socket, peer: tuple[str, int]) -> None:
        self.seen.append((sock, peer))
        self.arrived.release()
        while sock.recv(100):
            pass

    def wait(self) -> None:
        assert self.arrived.acquire(timeout=SOON)


@pytest.fixture
def clients() -> Iterator[list[socket.socket]]:
    opened: list[socket.socket] = []
    yield opened
    for sock in opened:
        sock.close()


def connect(server: TcpServer, clients: list[socket.socket]) -> socket.socket:
    sock = socket.create_connection(("127.0.0.1", server.port), SOON)
    clients.append(sock)
    return sock


def is_closed(sock: socket.socket) -> bool:
    """The server ended this connection: end of stream or reset, within SOON."""
    try:
        return sock.recv(1) == b""
    except ConnectionError:
        return True


def test_each_peer_has_its_own_blocking_socket_and_thread(clients: list[socket.socket]) -> None:
    holder = Holder()
    with TcpServer("127.0.0.1", 0, holder) as server:
        ours = [connect(server, clients) for _ in range(3)]
        for _ in ours:
            holder.wait()
        assert sorted(peer for _, peer in holder.seen) == sorted(sock.getsockname() for sock in ours)
        assert all(sock.gettimeout() is None for sock, _ in holder.seen)
        assert server.connections == server.pending == server.stats.accepted == 3


def test_the_socket_is_closed_when_the_handler_returns(clients: list[socket.socket]) -> None:
    with TcpServer("127.0.0.1", 0, lambda sock, _peer: sock.sendall(b"x")) as server:
        sock = connect(server, clients)
        assert sock.recv(1) == b"x"
        assert is_closed(sock)
        until(lambda: server.connections == 0)
        assert server.pending == 0


def test_a_failing_handler_costs_its_own_connection(
    clients: list[socket.socket], caplog: pytest.LogCaptureFixture
) -> None:
    def handler(sock: socket.socket, _peer: tuple[str, int]) -> None:
        if sock.recv(1) == b"!":
            raise KeyError("bug")
        sock.sendall(b"fine")

    with TcpServer("127.0.0.1", 0, handler, name="test") as server, caplog.at_level(logging.ERROR):
        bad, good = connect(server, clients), connect(server, clients)
        bad.sendall(b"!")
        assert is_closed(bad)
        good.sendall(b"x")
        assert good.recv(4) == b"fine"
    assert "test: handler for 127.0.0.1" in caplog.text


@pytest.mark.parametrize(
    "error", [ConnectionResetError(errno.ECONNRESET, "reset"), OSError(errno.EBADF, "closed")]
)
def test_the_end_of_a_connection_is_no_failure_of_its_handler(
    clients: list[socket.socket], caplog: pytest.LogCaptureFixture, error: OSError
) -> None:
    def handler(_sock: socket.socket, _peer: tuple[str, int]) -> None:
        raise error

    with TcpServer("127.0.0.1", 0, handler) as server, caplog.at_level(logging.INFO):
        assert is_closed(connect(server, clients))
    assert not caplog.records


@pytest.mark.promise("`allow=` takes a list of addresses")
def test_a_peer_that_is_not_allowed_is_closed_at_once(clients: list[socket.socket]) -> None:
    holder = Holder()
    for allow in ([], {"10.0.0.7"}, lambda host: host != "127.0.0.1"):
        with TcpServer("127.0.0.1", 0, holder, allow=allow) as server:
            assert is_closed(connect(server, clients))
            assert server.stats.not_allowed == 1
    for allow in (["127.0.0.1"], lambda host: host == "127.0.0.1"):
        with TcpServer("127.0.0.1", 0, holder, allow=allow) as server:
            connect(server, clients)
            holder.wait()


@pytest.mark.promise("`allow=` takes a list of addresses")
def test_a_failing_allow_function_lets_nobody_in(clients: list[socket.socket]) -> None:
    holder = Holder()

    def allow(_host: str) -> bool:
        raise KeyError("bug")

    with TcpServer("127.0.0.1", 0, holder, allow=allow) as server:
        assert is_closed(connect(server, clients))
        assert is_closed(connect(server, clients))
        assert not holder.seen


@pytest.mark.promise("such a one, then the one that has been idle for longest")
def test_pending_handshakes_bounds_the_unready_and_drops_the_oldest(clients: list[socket.socket]) -> None:
    holder = Holder()
    with TcpServer("127.0.0.1", 0, holder, limits=Limits(pending_handshakes=2)) as server:
        socks = []
        for _ in range(3):
            socks.append(connect(server, clients))
            holder.wait()
        assert is_closed(socks[0])
        assert server.stats.dropped_pending == 1
        server.established(holder.seen[1][0])
        socks.append(connect(server, clients))
        holder.wait()
        assert server.stats.dropped_pending == 1
        assert server.pending == 2


def test_a_handler_that_never_says_established_stays_pending(clients: list[socket.socket]) -> None:
    """However long it takes: a request that drips in for a minute can be dropped as long as it is not complete."""
    holder, clock = Holder(), FakeClock()
    limits = Limits(pending_handshakes=1, handshake_seconds=10)
    with TcpServer("127.0.0.1", 0, holder, limits=limits, clock=clock) as server:
        slow = connect(server, clients)
        holder.wait()
        clock.advance(60)
        assert server.pending == 1
        connect(server, clients)
        holder.wait()
        assert is_closed(slow)
        assert server.stats.dropped_pending == 1


@pytest.mark.promise("of the address that has most of those")
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has all of 127.0.0.0/8")
def test_half_handshakes_of_one_address_push_no_other_out(clients: list[socket.socket]) -> None:
    """A node on a slow radio link, pending for longest, keeps its place however many connections another opens."""
    holder = Holder()
    with TcpServer("127.0.0.1", 0, holder, limits=Limits(pending_handshakes=4)) as server:
        slow = socket.create_connection(("127.0.0.1", server.port), SOON, ("127.0.0.2", 0))
        clients.append(slow)
        holder.wait()
        crowd = []
        for _ in range(20):
            crowd.append(connect(server, clients))
            holder.wait()
        assert server.stats.dropped_pending == 17
        assert all(is_closed(sock) for sock in crowd[:17])
        slow.settimeout(0.1)
        with pytest.raises(TimeoutError):
            slow.recv(1)


def test_connections_bounds_the_open_and_refuses_the_newest(clients: list[socket.socket]) -> None:
    holder = Holder()
    with TcpServer("127.0.0.1", 0, holder, limits=Limits(connections=2)) as server:
        first, _ = connect(server, clients), connect(server, clients)
        holder.wait()
        holder.wait()
        assert is_closed(connect(server, clients))
        assert server.stats.refused_full == 1
        first.close()
        until(lambda: server.connections == 1)
        connect(server, clients)
        holder.wait()


@pytest.mark.promise("such a one, then the one that has been idle for longest")
def test_the_longest_idle_connection_makes_room(clients: list[socket.socket]) -> None:
    holder = Holder()
    with TcpServer("127.0.0.1", 0, holder, limits=Limits(connections=2)) as server:
        socks = [connect(server, clients)]
        holder.wait()
        socks.append(connect(server, clients))
        holder.wait()
        server.idle(holder.seen[1][0])
        server.idle(holder.seen[0][0])
        connect(server, clients)
        holder.wait()
        assert is_closed(socks[1])
        assert server.stats.dropped_idle == 1
        server.established(holder.seen[0][0])  # busy again: not to be dropped
        until(lambda: server.connections == 2)
        assert is_closed(connect(server, clients))


def test_a_connection_that_is_handed_over_outlives_its_thread_and_the_server(
    clients: list[socket.socket],
) -> None:
    kept: queue.Queue[socket.socket] = queue.Queue()

    def handler(sock: socket.socket, _peer: tuple[str, int]) -> None:
        server.hand_over(sock)
        kept.put(sock)

    with TcpServer("127.0.0.1", 0, handler, limits=Limits(connections=1), name="handing") as server:
        sock = connect(server, clients)
        ours = kept.get(timeout=SOON)
        until(lambda: not any("handing 127" in thread.name for thread in threading.enumerate()))
        assert (server.connections, server.pending) == (1, 0)
        assert is_closed(connect(server, clients))
        ours.sendall(b"x")
        assert sock.recv(1) == b"x"
        server.released(ours)
        connect(server, clients)
        second = kept.get(timeout=SOON)
    with ours, second:
        ours.sendall(b"y")
        assert sock.recv(1) == b"y"


@pytest.mark.promise("rospy reads the header inside its accept loop")
def test_a_silent_peer_keeps_nobody_waiting(clients: list[socket.socket]) -> None:
    def echo(sock: socket.socket, _peer: tuple[str, int]) -> None:
        while data := sock.recv(100):
            sock.sendall(data)

    with TcpServer("127.0.0.1", 0, echo) as server:
        for _ in range(20):
            connect(server, clients)
        sock = connect(server, clients)
        sock.sendall(b"x")
        assert sock.recv(1) == b"x"


def test_close_ends_connections_and_threads_promptly_and_frees_the_port(clients: list[socket.socket]) -> None:
    holder = Holder()
    server = TcpServer("127.0.0.1", 0, holder, name="closing")
    socks = [connect(server, clients) for _ in range(5)]
    for _ in socks:
        holder.wait()
    start = time.monotonic()
    server.close(60.0)
    server.close(60.0)  # again: nothing happens
    assert time.monotonic() - start < 30.0
    assert all(is_closed(sock) for sock in socks)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("rosproto:closing")]
    assert server.connections == 0
    TcpServer("127.0.0.1", server.port, holder).close()
    assert "closed" in repr(server)


def test_close_right_after_the_start_is_no_race() -> None:
    """The accepting thread may not have run yet when it is told to end."""
    for _ in range(300):
        server = TcpServer("127.0.0.1", 0, lambda sock, peer: None)
        server.close(SOON)
        assert server.closed


def test_close_waits_for_a_stubborn_handler_only_so_long(clients: list[socket.socket]) -> None:
    release, entered = threading.Event(), threading.Event()

    def stubborn(_sock: socket.socket, _peer: tuple[str, int]) -> None:
        entered.set()
        release.wait(SOON)

    server = TcpServer("127.0.0.1", 0, stubborn)
    connect(server, clients)
    assert entered.wait(SOON)
    start = time.monotonic()
    server.close(timeout=0.05)
    assert time.monotonic() - start < SOON / 2
    release.set()


@pytest.mark.promise("such a one, then the one that has been idle for longest")
def test_running_out_of_file_descriptors_is_survived_and_logged_once(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch, clients: list[socket.socket]
) -> None:
    accept, left = socket.socket.accept, [3]

    def exhausted(listener: socket.socket) -> Any:
        if listener.getsockname()[1] == server.port and left[0]:
            left[0] -= 1
            raise OSError(errno.EMFILE, "Too many open files")
        return accept(listener)

    monkeypatch.setattr(tcp_server, "_ACCEPT_PAUSE", 0)
    holder = Holder()
    with TcpServer("127.0.0.1", 0, holder) as server, caplog.at_level(logging.WARNING):
        monkeypatch.setattr(socket.socket, "accept", exhausted)
        connect(server, clients)
        holder.wait()
        assert server.stats.failed == 3
    assert [record.getMessage() for record in caplog.records] == [
        f"! tcp: accept failed: [Errno {errno.EMFILE}] Too many open files; trying again"
    ]


def test_running_out_of_threads_costs_the_new_connection_only(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch, clients: list[socket.socket]
) -> None:
    def no_thread(_self: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    holder = Holder()
    with TcpServer("127.0.0.1", 0, holder) as server:
        with monkeypatch.context() as patch, caplog.at_level(logging.CRITICAL):
            patch.setattr(threading.Thread, "start", no_thread)
            assert is_closed(connect(server, clients))
            until(lambda: server.stats.failed == 1)
        connect(server, clients)
        holder.wait()
        assert server.connections == 1


def test_a_program_that_ends_is_no_failure(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch, clients: list[socket.socket]
) -> None:
    """CPython 3.12 refuses new threads from then on; the peer is sent away without a traceback."""

    def refuse(self: threading.Thread) -> None:
        raise RuntimeError("can't create new thread at interpreter shutdown")

    with TcpServer("127.0.0.1", 0, Holder()) as server, caplog.at_level(logging.DEBUG):
        monkeypatch.setattr(threading.Thread, "start", refuse)
        assert connect(server, clients).recv(1) == b""
        until(lambda: server.stats.failed == 1)
    assert caplog.records == []


def test_a_handler_may_close_its_server(clients: list[socket.socket]) -> None:
    done = threading.Event()

    def handler(_sock: socket.socket, _peer: tuple[str, int]) -> None:
        server.close()
        done.set()

    server = TcpServer("127.0.0.1", 0, handler)
    connect(server, clients)
    assert done.wait(SOON)
    server.close()


@pytest.mark.promise("A node listens on the one address")
def test_it_listens_on_the_given_address_only() -> None:
    with TcpServer("127.0.0.1", 0, Holder()) as server, pytest.raises(OSError):
        socket.create_connection(("127.0.0.2", server.port), SOON)
