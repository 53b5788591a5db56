"""local_socket: connections within one computer that need no TCP, and when TCP is taken all the same."""

from __future__ import annotations

import errno
import socket
import sys
from collections.abc import Iterator

import pytest

from rosproto.errors import ConnectionLost
from rosproto.transport import local_socket
from rosproto.transport.connecting import connect
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import listen
from rosproto.transport.tcp_server import TcpServer
from rosproto.transport.tcpros_io import peer_name
from tests.support import attacks

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="abstract sockets are Linux's")

SOON = 20.0
LOCAL = getattr(socket, "AF_UNIX", None)


class Greeter:
    """Sends each connection who it is for the server, and closes."""

    def __init__(self) -> None:
        self.name = ""

    def __call__(self, sock: socket.socket, peer: tuple[str, int]) -> None:
        self.name = peer_name(sock)
        sock.sendall(f"{peer[0]} {min(peer[1], 1)}".encode())


@pytest.fixture
def greeter() -> Greeter:
    return Greeter()


@pytest.fixture
def server(greeter: Greeter) -> Iterator[TcpServer]:
    with TcpServer("127.0.0.1", 0, greeter, local=True) as server:
        yield server


def greeting(sock: socket.socket) -> str:
    sock.settimeout(SOON)
    with sock:
        return attacks.read_exactly(sock, 11).decode()


def family(port: int, host: str = "127.0.0.1") -> socket.AddressFamily:
    """Of the socket that a connection is made with."""
    with connect(host, port, Deadline(SOON), local=True) as sock:
        return sock.family


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_a_port_of_this_computer_is_reached_without_tcp(
    server: TcpServer, greeter: Greeter, host: str
) -> None:
    sock = connect(host, server.port, Deadline(SOON), local=True)
    assert sock.family == LOCAL
    assert sock.gettimeout() is None
    assert peer_name(sock) == f"127.0.0.1:{server.port}"
    assert greeting(sock) == "127.0.0.1 0"
    assert greeter.name == "peer"


def test_who_does_not_ask_for_it_gets_tcp(server: TcpServer) -> None:
    sock = connect("127.0.0.1", server.port, Deadline(SOON))
    assert sock.family == socket.AF_INET
    assert greeting(sock) == "127.0.0.1 1"


def test_a_port_that_has_none_is_reached_by_tcp() -> None:
    with listen("127.0.0.1") as listener:
        assert family(listener.getsockname()[1]) == socket.AF_INET


def test_the_name_ends_with_its_server(greeter: Greeter) -> None:
    with TcpServer("127.0.0.1", 0, greeter, local=True) as server:
        port = server.port
    with pytest.raises(ConnectionLost, match="refused"):
        connect("127.0.0.1", port, Deadline(SOON), local=True)


def test_a_listener_of_another_user_is_not_trusted(
    server: TcpServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    class OfSomebodyElse:
        size = local_socket._CREDENTIALS.size
        unpack = staticmethod(lambda _data: (1, 4711, 4711))

    assert family(server.port) == LOCAL
    monkeypatch.setattr(local_socket, "_CREDENTIALS", OfSomebodyElse)
    assert family(server.port) == socket.AF_INET


def test_a_name_that_is_taken_leaves_the_port() -> None:
    with listen("127.0.0.1") as listener:
        first = local_socket.listen_locally(listener)
        assert first is not None
        with first:
            assert local_socket.listen_locally(listener) is None


@pytest.mark.parametrize(("name", "value"), [("_AHEAD", 1 << 30), ("sys.platform", "darwin")])
def test_a_system_that_lacks_it_has_tcp(
    greeter: Greeter, monkeypatch: pytest.MonkeyPatch, name: str, value: object
) -> None:
    with listen("127.0.0.1") as listener:
        monkeypatch.setattr(f"rosproto.transport.local_socket.{name}", value)
        assert local_socket.listen_locally(listener) is None
        assert family(listener.getsockname()[1]) == socket.AF_INET


def test_without_a_file_left_tcp_is_to_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_file_left(*_: object) -> None:
        raise OSError(errno.EMFILE, "no file left")

    with listen("127.0.0.1") as listener, monkeypatch.context() as patch:
        patch.setattr("rosproto.transport.local_socket.socket.socket", no_file_left)
        assert local_socket.listen_locally(listener) is None
        assert local_socket.connect_locally("127.0.0.1", 1) is None


def test_who_may_not_connect_may_not_here_either(greeter: Greeter) -> None:
    with TcpServer("127.0.0.1", 0, greeter, local=True, allow=["10.0.0.1"]) as server:
        with connect("127.0.0.1", server.port, Deadline(SOON), local=True) as sock:
            assert sock.family == LOCAL
            assert sock.recv(1) == b""
        assert server.stats.not_allowed == 1


def test_an_address_of_tcp_names_no_local_socket() -> None:
    assert local_socket.name_of(("127.0.0.1", 1)) is None
    assert local_socket.name_of("") is None


@pytest.fixture
def local_pair() -> Iterator[tuple[socket.socket, socket.socket]]:
    """(sender, receiver) on a local socket."""
    with listen("127.0.0.1") as listener:
        accepting = local_socket.listen_locally(listener)
        if accepting is None:
            pytest.skip("there are no local sockets here")
        with accepting:
            receiver = local_socket.connect_locally(*listener.getsockname())
            assert receiver is not None
            receiver.settimeout(20)
            with receiver, accepting.accept()[0] as sender:
                yield sender, receiver


@pytest.mark.parametrize("pause", [0.0, 30.0])
def test_what_was_called_void_is_not_handed_out_after_a_pause(
    pause: float, local_pair: tuple[socket.socket, socket.socket], monkeypatch: pytest.MonkeyPatch
) -> None:
    sender, receiver = local_pair
    now = [100.0]
    monkeypatch.setattr(local_socket, "monotonic", lambda: now[0])
    buffer = bytearray(100)
    sender.send(b"new")
    assert receiver.recv_into(buffer) == 3
    sender.send(b"old")
    local_socket.make_void(sender)
    assert not local_socket.has_left(sender)
    now[0] += pause
    if pause:
        with pytest.raises(ConnectionLost, match="too old"):
            receiver.recv_into(buffer)
    else:
        assert receiver.recv_into(buffer) == 3, "it was about to read"
    receiver.close()
    assert local_socket.has_left(sender)


def test_nothing_is_handed_out_after_ones_own_end(local_pair: tuple[socket.socket, socket.socket]) -> None:
    """A link that is ended while its program was stopped: its reader would find half a minute of messages."""
    sender, receiver = local_pair
    sender.send(b"old")
    receiver.shutdown(socket.SHUT_RDWR)
    assert receiver.recv_into(bytearray(100)) == 0


@pytest.mark.parametrize("ends", [False, True])
def test_the_last_words_of_a_quiet_sender_are_handed_out(
    ends: bool, local_pair: tuple[socket.socket, socket.socket], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was silent for long, says something, and may leave at once: nothing is too old."""
    sender, receiver = local_pair
    now = [100.0]
    monkeypatch.setattr(local_socket, "monotonic", lambda: now[0])
    buffer = bytearray(100)
    sender.send(b"first")
    receiver.recv_into(buffer)
    now[0] += 30.0
    sender.send(b"last")
    if ends:
        sender.shutdown(socket.SHUT_RDWR)
        sender.close()
    assert receiver.recv_into(buffer) == 4
