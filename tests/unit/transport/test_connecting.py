"""Connecting: one deadline over all addresses, and parallel attempts while none is answered."""

from __future__ import annotations

import errno
import socket
import sys
import threading
from collections.abc import Iterator

import pytest

from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.transport import tcp
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import connect

SOON = 20.0


@pytest.fixture
def silent() -> Iterator[socket.socket]:
    """A listener that answers nobody: its queue is full. `accept` lets the next one in."""
    if sys.platform != "linux":
        pytest.skip("what a full queue of connections does differs among systems")
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(0)
        with socket.create_connection(listener.getsockname()):
            yield listener


class Begun(list[tuple[str, int]]):
    """The addresses of the attempts so far.

    Attributes:
        sockets: The socket of each.
        instead: Where an attempt really goes, by its number.
    """

    def __init__(self) -> None:
        super().__init__()
        self.sockets: list[socket.socket] = []
        self.instead: dict[int, tuple[str, int]] = {}

    @property
    def open(self) -> list[int]:
        """The numbers of the attempts whose sockets are open."""
        return [number for number, sock in enumerate(self.sockets) if sock.fileno() != -1]


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> Begun:
    """Hurry, and note each attempt of this thread; what another test has left may connect as well."""
    addresses, own = Begun(), threading.current_thread()

    class Noting(socket.socket):
        def connect(self, address: object) -> None:
            if threading.current_thread() is not own:
                return super().connect(address)  # type: ignore[arg-type]
            addresses.sockets.append(self)
            addresses.append(address)  # type: ignore[arg-type]
            return super().connect(addresses.instead.get(len(addresses) - 1, address))  # type: ignore[arg-type]

    monkeypatch.setattr(tcp, "FIRST_ATTEMPT_SECONDS", 0.05)
    monkeypatch.setattr(tcp, "NEXT_ATTEMPT_SECONDS", 0.02)
    monkeypatch.setattr(tcp.socket, "socket", Noting)
    return addresses


def test_connect_gives_a_blocking_tuned_socket() -> None:
    with tcp.listen("127.0.0.1") as listener:
        sock = connect("127.0.0.1", listener.getsockname()[1], Deadline(SOON))
    with sock:
        assert sock.gettimeout() is None
        assert sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
        assert sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)


def test_a_late_answer_to_the_first_attempt_counts(
    silent: socket.socket, begun: Begun, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first attempt is not given up while others are made."""
    with socket.create_server(("127.0.0.1", 0)) as open_one:
        begun.instead[2] = open_one.getsockname()
        open_then: list[list[int]] = []
        note = begun.append
        monkeypatch.setattr(begun, "append", lambda address: (note(address), open_then.append(begun.open)))
        with connect("127.0.0.1", silent.getsockname()[1], Deadline(SOON)) as sock:
            assert sock.getpeername() == open_one.getsockname()
        assert open_then == [[0], [0, 1], [0, 1, 2]]
        assert begun.open == []


def test_one_that_is_back_is_found_by_the_next_attempt(
    silent: socket.socket, begun: Begun, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The system would repeat the first attempt after a second, and the later the longer it was away."""
    port = silent.getsockname()[1]
    let_in = begun.append

    def back_after_three(address: tuple[str, int]) -> None:
        let_in(address)
        if len(begun) == 4:
            silent.accept()[0].close()

    monkeypatch.setattr(begun, "append", back_after_three)
    with connect("127.0.0.1", port, Deadline(30.0)) as sock:
        assert sock.getpeername()[1] == port
        assert sock.gettimeout() is None
    assert len(begun) >= 4


def test_what_is_pending_is_bounded(
    silent: socket.socket, begun: Begun, monkeypatch: pytest.MonkeyPatch
) -> None:
    last, note = tcp.MAX_PENDING + 4, begun.append
    open_then: list[int] = []

    def refused_in_the_end(address: tuple[str, int]) -> None:
        note(address)
        if len(begun) == last:
            open_then.extend(begun.open)
            raise ConnectionRefusedError(errno.ECONNREFUSED, "refused")

    monkeypatch.setattr(begun, "append", refused_in_the_end)
    with pytest.raises(ConnectionLost, match="refused"):
        connect("127.0.0.1", silent.getsockname()[1], Deadline(60.0))
    assert open_then == list(range(3, last)), "those that are pending, and this one"
    assert begun.open == []


def test_a_silent_peer_costs_the_deadline_and_is_named(silent: socket.socket) -> None:
    port = silent.getsockname()[1]
    with pytest.raises(RosTimeout, match=rf"127\.0\.0\.1:{port}.*0\.2 s.*check the address, the cable"):
        connect("127.0.0.1", port, Deadline(0.2))


def test_a_refused_address_does_not_hold_up_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tcp, "resolve", lambda *_: ["127.0.0.2", "127.0.0.1"])
    with tcp.listen("127.0.0.1") as listener:
        connect("robot", listener.getsockname()[1], Deadline(SOON)).close()


def test_an_address_is_not_tried_again_once_it_refused(
    silent: socket.socket, begun: Begun, monkeypatch: pytest.MonkeyPatch
) -> None:
    """127.0.0.2 refuses, nothing listens there; 127.0.0.1 is silent."""
    monkeypatch.setattr(tcp, "resolve", lambda *_: ["127.0.0.2", "127.0.0.1"])
    port = silent.getsockname()[1]
    with pytest.raises(ConnectionLost, match=rf"127\.0\.0\.2:{port} \(robot\).*refused"):
        connect("robot", port, Deadline(0.3))
    assert [host for host, _ in begun].count("127.0.0.2") == 1
    assert [host for host, _ in begun].count("127.0.0.1") > 3


def test_refused_names_the_address_and_asks_for_the_master() -> None:
    with tcp.listen("127.0.0.1") as listener:
        port = listener.getsockname()[1]
    with pytest.raises(ConnectionLost, match=rf"127\.0\.0\.1:{port}.*refused.*running") as caught:
        connect("127.0.0.1", port, Deadline(SOON))
    assert caught.value.peer == f"127.0.0.1:{port}"
    assert isinstance(caught.value.__cause__, ConnectionRefusedError)


def test_localhost_is_127_0_0_1_first_and_named_in_the_error() -> None:
    with tcp.listen("localhost") as listener:
        host, port = listener.getsockname()
        assert host == "127.0.0.1"
        connect("localhost", port, Deadline(SOON)).close()
    with pytest.raises(ConnectionLost, match=rf"127\.0\.0\.1:{port} \(localhost\)"):
        connect("localhost", port, Deadline(SOON))


def test_an_expired_deadline_connects_nowhere() -> None:
    with pytest.raises(RosTimeout, match="check the address, the cable"):
        connect("127.0.0.1", 11311, Deadline(0))


def test_no_route_is_told_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    class NoRoute(socket.socket):
        def connect(self, address: object) -> None:
            raise OSError(errno.ENETUNREACH, "Network is unreachable")

    monkeypatch.setattr(tcp.socket, "socket", NoRoute)
    with pytest.raises(ConnectionLost, match="no route there"):
        connect("10.255.0.1", 11311, Deadline(30.0))


def test_a_process_that_may_open_no_more_files_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ours, with what to do; not the system's bare error."""

    def none_left(*_: object) -> socket.socket:
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr(socket, "socket", none_left)
    with pytest.raises(ConnectionLost, match=r"connect to 127.0.0.1:5: too many open files .*ulimit"):
        connect("127.0.0.1", 5, Deadline(5.0))


def test_a_connection_to_itself_counts_as_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(socket.socket, "getpeername", socket.socket.getsockname)
    with tcp.listen("127.0.0.1") as listener, pytest.raises(ConnectionLost, match="refused"):
        connect("127.0.0.1", listener.getsockname()[1], Deadline(SOON))


@pytest.mark.parametrize("port", [0, -1, 65536])
def test_ports_that_are_none_are_told(port: int) -> None:
    with pytest.raises(ConnectionLost, match="port"):
        connect("127.0.0.1", port, Deadline(SOON))
