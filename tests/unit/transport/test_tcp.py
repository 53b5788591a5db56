"""Listening and tuning TCP sockets, and the connection header on a socket."""

from __future__ import annotations

import errno
import socket
import struct
import sys
import threading
from collections.abc import Iterator

import pytest

from rosproto.errors import ConnectionLost, LocalProtocolError, RemoteProtocolError, RosTimeout, TooLarge
from rosproto.protocol.handshake import encode_header
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import tcp
from rosproto.transport.deadline import Deadline
from rosproto.transport.os_errors import translate
from rosproto.transport.tcp import (
    ClosedBeforeHeader,
    connect,
    peer_name,
    read_header,
    write_all,
    write_header,
)

SOON = 20.0


@pytest.fixture
def pair() -> Iterator[tuple[socket.socket, socket.socket]]:
    one, other = socket.socketpair()
    with one, other:
        yield one, other


@pytest.mark.skipif(sys.platform != "linux", reason="option names of Linux")
def test_a_vanished_peer_is_noticed_after_thirty_seconds() -> None:
    with socket.socket() as sock:
        tcp.tune(sock)
        options = [socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT, socket.TCP_USER_TIMEOUT]
        idle, interval, count, user = (sock.getsockopt(socket.IPPROTO_TCP, option) for option in options)
        assert idle + interval * count == 30
        assert user == 30_000


@pytest.mark.skipif(sys.platform != "linux", reason="option names of Linux")
def test_where_we_only_receive_silence_is_noticed_after_five_seconds() -> None:
    with socket.socket() as sock:
        tcp.tune(sock)
        tcp.expect_data(sock)
        options = [socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT, socket.TCP_USER_TIMEOUT]
        idle, interval, count, user = (sock.getsockopt(socket.IPPROTO_TCP, option) for option in options)
        assert idle + interval * count == 5
        assert user == 5_000


@pytest.mark.skipif(sys.platform != "linux", reason="an option of Linux")
def test_what_was_lost_is_repeated_every_second_where_the_system_can() -> None:
    rto_max_ms = 44  # TCP_RTO_MAX_MS of linux/tcp.h
    with socket.socket() as sock:
        try:
            sock.getsockopt(socket.IPPROTO_TCP, rto_max_ms)
        except OSError:
            pytest.skip("Linux older than 6.15")
        tcp.tune(sock)
        assert sock.getsockopt(socket.IPPROTO_TCP, rto_max_ms) == 1000


def test_tuning_something_without_tcp_options_is_no_error(pair: tuple[socket.socket, socket.socket]) -> None:
    tcp.tune(pair[0])


def test_windows_keep_alive_is_set_through_ioctl(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[tuple[object, object]] = []

    class Windows:
        def setsockopt(self, *_: object) -> None: ...

        def ioctl(self, control: object, value: object) -> None:
            calls.append((control, value))

    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(socket, "SIO_KEEPALIVE_VALS", 0x98000004, raising=False)
    tcp.tune(Windows())  # type: ignore[arg-type]
    assert calls == [(0x98000004, (1, 10_000, 2_000))]  # ten probes, always: 30 s in all


@pytest.mark.parametrize(
    ("platform", "options"),
    [("win32", [(socket.IPPROTO_TCP, 5, 4)]), ("darwin", [(socket.IPPROTO_TCP, 0x80, 4)]), ("linux", [])],
)
def test_what_nobody_acknowledges_is_given_up_by_the_system_where_it_tells_no_more(
    monkeypatch: pytest.MonkeyPatch, platform: str, options: list[tuple[int, int, int]]
) -> None:
    """TCP_MAXRT and TCP_RXT_CONNDROPTIME, in seconds; Linux tells what is on its way, and nothing is set."""
    calls: list[tuple[int, int, int]] = []

    class Other:
        def setsockopt(self, level: int, option: int, value: int) -> None:
            calls.append((level, option, value))

    monkeypatch.setattr(sys, "platform", platform)
    assert tcp.expect_acknowledgement(Other(), 4) is bool(options)  # type: ignore[arg-type]
    assert calls == options


def test_a_system_that_cannot_give_up_says_so(
    monkeypatch: pytest.MonkeyPatch, pair: tuple[socket.socket, socket.socket]
) -> None:
    """A socket pair has no option of TCP."""
    monkeypatch.setattr(sys, "platform", "darwin")
    assert not tcp.expect_acknowledgement(pair[0], 4)


@pytest.mark.promise("A node listens on one address, on a")
def test_windows_listens_with_exclusive_address_use(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    class Windows:
        def setsockopt(self, *arguments: object) -> None:
            calls.append(arguments)

    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(socket, "SO_EXCLUSIVEADDRUSE", -5, raising=False)
    tcp.reuse_address(Windows())  # type: ignore[arg-type]
    assert calls == [(socket.SOL_SOCKET, -5, 1)]


def test_a_taken_port_is_told() -> None:
    with tcp.listen("127.0.0.1") as listener:
        port = listener.getsockname()[1]
        with pytest.raises(ConnectionLost, match=rf"127\.0\.0\.1:{port}.*taken"):
            tcp.listen("127.0.0.1", port)


def test_a_port_is_free_again_at_once_after_its_server_closed() -> None:
    with tcp.listen("127.0.0.1") as listener:
        port = listener.getsockname()[1]
        client = connect("127.0.0.1", port, Deadline(SOON))
        server, _ = listener.accept()
    server.close()  # first, so this side keeps the port in TIME_WAIT
    client.close()
    tcp.listen("127.0.0.1", port).close()


@pytest.mark.parametrize(
    ("host", "port", "error"), [("192.0.2.1", 0, ConnectionLost), ("127.0.0.1", 70000, ConnectionLost)]
)
def test_what_cannot_be_listened_on_is_told(host: str, port: int, error: type[Exception]) -> None:
    with pytest.raises(error, match=r"listen on"):
        tcp.listen(host, port)


def test_an_empty_host_is_not_taken_for_all_interfaces() -> None:
    with pytest.raises(ValueError, match=r"0\.0\.0\.0"):
        tcp.listen("")


def test_interrupt_wakes_a_thread_that_reads(pair: tuple[socket.socket, socket.socket]) -> None:
    reading, ended = threading.Event(), threading.Event()

    def read() -> None:
        reading.set()
        try:
            pair[0].recv(1)
        except OSError:
            pass  # Windows, where it ends with an error
        ended.set()

    thread = threading.Thread(target=read)
    thread.start()
    assert reading.wait(SOON)
    tcp.interrupt(pair[0])
    assert ended.wait(SOON)
    thread.join()
    tcp.interrupt(pair[0])  # again: nothing happens


def test_system_errors_say_what_to_check() -> None:
    for number, words in (
        (errno.ECONNREFUSED, "running"),
        (errno.EHOSTUNREACH, "cable"),
        (errno.ECONNRESET, "closed by the other side"),
        (errno.EADDRINUSE, "another"),
        (errno.EADDRNOTAVAIL, "ROS_HOSTNAME"),
        (errno.EMFILE, "ulimit"),
        (getattr(errno, "EHOSTDOWN", 10064), "cable"),
        (
            getattr(errno, "EPROTOTYPE", 10054),
            "closed by the other side",
        ),  # macOS: a send during the other's close
        (errno.EDOM, "Too many open files"),  # the system's own words
    ):
        error = translate(OSError(number, "Too many open files"), "doing", "peer")
        assert isinstance(error, ConnectionLost)
        assert words in str(error)
    assert isinstance(translate(TimeoutError(), "doing", "peer"), RosTimeout)


def test_a_peer_that_vanished_is_a_lost_connection_not_a_time_out_of_ours() -> None:
    error = translate(OSError(errno.ETIMEDOUT, "Connection timed out"), "read", "peer")
    assert isinstance(error, ConnectionLost)
    assert "power" in str(error)


# -- header and exact reads


@pytest.mark.promise("One segment may carry the rest of a")
def test_a_header_goes_over_and_nothing_behind_it_is_read(pair: tuple[socket.socket, socket.socket]) -> None:
    one, other = pair
    write_header(one, {"topic": "/t"}, Deadline(SOON))
    one.sendall(b"message")
    assert read_header(other, Limits(), Deadline(SOON)) == {"topic": "/t"}
    assert other.recv(100) == b"message"
    assert one.gettimeout() is other.gettimeout() is None


def test_a_header_may_come_byte_by_byte(pair: tuple[socket.socket, socket.socket]) -> None:
    one, other = pair
    data = encode_header({"topic": "/t", "md5sum": "*"})

    def send() -> None:
        for byte in data:
            one.send(bytes([byte]))

    sender = threading.Thread(target=send)
    sender.start()
    assert read_header(other, Limits(), Deadline(SOON)) == {"topic": "/t", "md5sum": "*"}
    sender.join()


def test_a_long_header_is_read_as_it_comes_and_nothing_behind_it(
    pair: tuple[socket.socket, socket.socket],
) -> None:
    """Definitions are as long as this; a peer that announces much and sends little takes no memory for it."""
    one, other = pair
    fields = {"message_definition": "x" * 500_000, "topic": "/t"}
    sender = threading.Thread(target=lambda: one.sendall(encode_header(fields) + b"message"))
    sender.start()
    assert read_header(other, Limits(), Deadline(SOON)) == fields
    assert other.recv(100) == b"message"
    sender.join()


def test_a_silent_peer_costs_the_deadline_only(pair: tuple[socket.socket, socket.socket]) -> None:
    pair[0].sendall(b"\x10\0\0\0abc")
    with pytest.raises(RosTimeout, match="read a connection header"):
        read_header(pair[1], Limits(), Deadline(0.02))


def test_a_probe_that_closes_without_a_byte_is_told_apart(pair: tuple[socket.socket, socket.socket]) -> None:
    pair[0].close()
    with pytest.raises(ClosedBeforeHeader):
        read_header(pair[1], Limits(), Deadline(SOON))


@pytest.mark.parametrize("data", [b"\x10", b"\x10\0\0\0", b"\x10\0\0\0abc"])
def test_a_peer_that_closes_inside_its_header_is_lost(
    pair: tuple[socket.socket, socket.socket], data: bytes
) -> None:
    pair[0].sendall(data)
    pair[0].close()
    with pytest.raises(ConnectionLost) as caught:
        read_header(pair[1], Limits(), Deadline(SOON))
    assert type(caught.value) is ConnectionLost


def test_header_bytes_bounds_the_header(pair: tuple[socket.socket, socket.socket]) -> None:
    pair[0].sendall(struct.pack("<I", 101))
    with pytest.raises(TooLarge, match="header_bytes"):
        read_header(pair[1], Limits(header_bytes=100), Deadline(SOON))


def test_nonsense_is_the_peers_error(pair: tuple[socket.socket, socket.socket]) -> None:
    pair[0].sendall(b"\x04\0\0\0abcd")
    with pytest.raises(RemoteProtocolError):
        read_header(pair[1], Limits(), Deadline(SOON))


def test_what_cannot_be_encoded_is_not_sent(pair: tuple[socket.socket, socket.socket]) -> None:
    with pytest.raises(LocalProtocolError):
        write_header(pair[0], {"a=b": "c"}, Deadline(SOON))


def test_writing_to_a_peer_that_does_not_read_times_out(pair: tuple[socket.socket, socket.socket]) -> None:
    with pytest.raises(RosTimeout, match="write to"):
        write_all(pair[0], bytes(10_000_000), Deadline(0.02))


def test_writing_to_a_peer_that_is_gone_is_a_lost_connection(
    pair: tuple[socket.socket, socket.socket],
) -> None:
    pair[1].close()
    with pytest.raises(ConnectionLost, match="closed by the other side"):
        write_all(pair[0], bytes(1_000_000), Deadline(SOON))


def test_a_socket_that_is_gone_is_called_peer(pair: tuple[socket.socket, socket.socket]) -> None:
    pair[0].close()
    assert peer_name(pair[0]) == "peer"


@pytest.mark.skipif(sys.platform == "darwin", reason="the BSDs let a wildcard listen beside one address")
def test_no_other_socket_listens_on_the_port_of_a_listener() -> None:
    """Also not on all addresses at once."""
    with tcp.listen("127.0.0.1") as listener, pytest.raises(ConnectionLost, match="the port is taken"):
        tcp.listen("0.0.0.0", listener.getsockname()[1])
