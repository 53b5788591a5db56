"""Client link and server session joined by a socket pair: requests, answers, and every way it can go wrong."""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from rosproto.errors import ConnectionLost, RemoteProtocolError, RosTimeout, ServiceError, TooLarge
from rosproto.node.services.link import ServiceLink
from rosproto.node.services.server import ServiceSession
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.deadline import Deadline


def answer(body: bytes, ok: int = 1) -> bytes:
    return struct.pack("<BI", ok, len(body)) + body


def echo(request: bytes) -> bytes:
    return answer(request)


class CountingSocket:
    """A socket that tells when reading from it has timed out twice."""

    def __init__(self, sock: socket.socket) -> None:
        self._sock, self._left, self.timed_out_twice = sock, 2, threading.Event()

    def __getattr__(self, name: str) -> object:
        return getattr(self._sock, name)

    def recv_into(self, space: memoryview) -> int:
        try:
            return self._sock.recv_into(space)
        except TimeoutError:
            self._left -= 1
            if not self._left:
                self.timed_out_twice.set()
            raise


sessions: list[threading.Thread] = []  # of the test that runs


@pytest.fixture
def pair() -> Iterator[tuple[socket.socket, socket.socket]]:
    ours, theirs = socket.socketpair()
    yield ours, theirs
    ours.close()
    while sessions:
        sessions.pop().join(20)
    theirs.close()  # not before: a session that still ends would shut down the next test's socket of this number


def link_on(sock: socket.socket, limits: Limits | None = None) -> ServiceLink:
    return ServiceLink(sock, {}, service="/s", peer="peer:1", limits=limits or Limits())


def serving(
    sock: socket.socket, handler: Callable[[bytes], bytes], **options: object
) -> tuple[ServiceSession, threading.Thread]:
    options = {"persistent": True, "limits": Limits(), **options}
    session = ServiceSession(sock, handler, peer="peer:2", **options)  # type: ignore[arg-type]
    thread = threading.Thread(target=session.run, daemon=True)
    sessions.append(thread)
    thread.start()
    return session, thread


def read_slowly(sock: socket.socket) -> int:
    """Read three megabytes a second at most, until the other side closes; return how many bytes came."""
    count = 0
    while part := sock.recv(60_000):
        count += len(part)
        time.sleep(0.02)
    return count


@pytest.mark.parametrize("size", [0, 1, 4, 65531, 65532, 70_000, 3_000_000])
def test_a_request_of_any_size_comes_back(pair, size):
    serving(pair[1], echo)
    link, body = link_on(pair[0]), bytes(size)
    for _ in range(3):
        assert link.call(body, Deadline(10)) == body
    assert link.usable


def test_an_answer_byte_by_byte_is_put_together(pair):
    link = link_on(pair[0])

    def dribble() -> None:
        pair[1].recv(100)
        for byte in answer(b"hello"):
            pair[1].send(bytes([byte]))

    thread = threading.Thread(target=dribble)
    thread.start()
    assert link.call(b"x", Deadline(10)) == b"hello"
    thread.join()


@pytest.mark.promise("A refusal is one byte 0, a length")
def test_an_error_answer_is_a_service_error_and_the_link_stays_in_step(pair):
    answers = iter([answer(b"no \xff way", ok=0), answer(b"yes")])
    serving(pair[1], lambda request: next(answers))
    link = link_on(pair[0])
    with pytest.raises(ServiceError) as caught:
        link.call(b"", Deadline(10))
    assert caught.value.text == "no \\xff way"
    assert link.call(b"", Deadline(10)) == b"yes"


def test_a_provider_that_dies_during_the_call_is_lost_at_once(pair):
    link = link_on(pair[0])
    thread = threading.Thread(target=lambda: (pair[1].recv(100), pair[1].close()))
    thread.start()
    with pytest.raises(ConnectionLost, match="may or may not"):
        link.call(b"x", Deadline(None))
    thread.join()


def test_a_provider_that_dies_within_its_answer_is_lost(pair):
    pair[1].send(answer(bytes(100))[:50])
    pair[1].shutdown(socket.SHUT_WR)
    with pytest.raises(ConnectionLost):
        link_on(pair[0]).call(b"x", Deadline(10))


def test_a_silent_provider_is_a_timeout(pair):
    with pytest.raises(RosTimeout, match="did not answer in time"):
        link_on(pair[0]).call(b"x", Deadline(0.02))


def test_a_provider_that_dribbles_for_ever_does_not_stretch_the_deadline(pair):
    pair[1].send(answer(bytes(100))[:50])
    with pytest.raises(RosTimeout):
        link_on(pair[0]).call(b"x", Deadline(0.02))


def test_a_provider_that_reads_slowly_does_not_stretch_the_deadline(pair):
    thread = threading.Thread(target=read_slowly, args=(pair[1],))
    thread.start()
    begun = time.monotonic()
    with pytest.raises(RosTimeout):
        link_on(pair[0]).call(bytes(50_000_000), Deadline(0.2))
    assert time.monotonic() - begun < 5
    pair[0].close()
    thread.join()


def test_an_enormous_answer_is_refused_before_it_is_read(pair):
    pair[1].send(struct.pack("<BI", 1, 0xFFFFFFFF))
    with pytest.raises(TooLarge):
        link_on(pair[0], Limits(message_bytes=1000)).call(b"x", Deadline(10))


def test_two_answers_to_one_request_break_the_protocol(pair):
    pair[1].send(answer(b"a") + answer(b"b"))
    with pytest.raises(RemoteProtocolError, match="6 bytes after"):
        link_on(pair[0]).call(b"x", Deadline(10))


def test_a_link_closed_by_the_other_side_is_not_usable(pair):
    link = link_on(pair[0])
    assert link.usable
    pair[1].close()
    assert not link.usable


def test_closing_wakes_the_call_in_another_thread(pair):
    link = link_on(pair[0])
    threading.Thread(target=lambda: (pair[1].recv(10), link.close()), daemon=True).start()
    with pytest.raises(ConnectionLost):
        link.call(b"x", Deadline(10))


@pytest.mark.promise("Several requests may be sent before the first")
def test_pipelined_requests_are_answered_in_order(pair):
    requests = [bytes([n]) * n for n in range(50)]
    serving(pair[1], echo)
    pair[0].sendall(b"".join(struct.pack("<I", len(r)) + r for r in requests))
    expected = b"".join(map(answer, requests))
    got = b""
    while len(got) < len(expected):
        got += pair[0].recv(65536)
    assert got == expected


def test_a_session_that_is_not_persistent_ends_after_one_answer(pair):
    _, thread = serving(pair[1], echo, persistent=False)
    pair[0].sendall(struct.pack("<I", 1) + b"x")
    got = b""
    while part := pair[0].recv(100):
        got += part
    assert got == answer(b"x")
    thread.join(20)
    assert not thread.is_alive()


@pytest.mark.parametrize("sent", [b"", b"\x05", b"\x05\0\0\0", b"\x05\0\0\0abc"])
def test_a_client_that_leaves_anywhere_ends_its_session_quietly(pair, sent, caplog):
    calls: list[bytes] = []
    _, thread = serving(pair[1], lambda request: calls.append(request) or answer(b""))
    pair[0].sendall(sent)
    pair[0].close()
    thread.join(20)
    assert not thread.is_alive()
    assert calls == []
    assert [r for r in caplog.records if r.levelname in ("WARNING", "ERROR")] == []


def test_an_enormous_request_ends_the_session(pair):
    _, thread = serving(pair[1], echo, limits=Limits(message_bytes=1000))
    pair[0].sendall(struct.pack("<I", 1001))
    assert pair[0].recv(10) == b""
    thread.join(20)


def test_a_request_that_stalls_ends_the_session_but_an_idle_link_stays(pair):
    idle = CountingSocket(pair[1])
    _, thread = serving(idle, echo, stall_seconds=0.02)
    link = link_on(pair[0])
    assert link.call(b"x", Deadline(10)) == b"x"
    assert idle.timed_out_twice.wait(20)
    assert link.call(b"y", Deadline(10)) == b"y"
    pair[0].sendall(b"\x05\0\0\0ab")
    thread.join(20)
    assert not thread.is_alive()


def test_a_client_that_never_reads_its_answers_ends_its_session(pair):
    _, thread = serving(pair[1], lambda request: answer(bytes(50_000_000)), stall_seconds=0.05)
    pair[0].sendall(struct.pack("<I", 0))
    thread.join(20)
    assert not thread.is_alive()


def test_a_client_that_stops_reading_within_an_answer_ends_its_session(pair):
    _, thread = serving(pair[1], lambda request: answer(bytes(50_000_000)), stall_seconds=0.05)
    pair[0].sendall(struct.pack("<I", 0))
    assert len(pair[0].recv(1_000_000)) > 0
    thread.join(20)
    assert not thread.is_alive()


def test_an_answer_may_take_longer_than_the_limit_while_its_bytes_flow(pair):
    size, stall_seconds = 2_000_000, 0.5
    serving(pair[1], lambda request: answer(bytes(size)), persistent=False, stall_seconds=stall_seconds)
    pair[0].sendall(struct.pack("<I", 0))
    begun = time.monotonic()
    assert read_slowly(pair[0]) == len(answer(bytes(size)))
    assert time.monotonic() - begun > stall_seconds


def test_finishing_an_idle_session_ends_it(pair):
    session, thread = serving(pair[1], echo)
    link_on(pair[0]).call(b"x", Deadline(10))
    session.finish()
    assert session.join(20)
    thread.join(20)
    assert not thread.is_alive()


def test_finishing_lets_the_answer_in_progress_out(pair):
    called, go = threading.Event(), threading.Event()

    def slow(request: bytes) -> bytes:
        called.set()
        go.wait(20)
        return answer(b"late")

    session, _ = serving(pair[1], slow)
    pair[0].sendall(struct.pack("<I", 0))
    assert called.wait(20)
    session.finish()
    go.set()
    assert session.join(20)
    assert pair[0].recv(100) == answer(b"late")
    assert pair[0].recv(100) == b""


def test_a_hanging_handler_is_cut_off_in_time(pair):
    called, go = threading.Event(), threading.Event()

    def hang(request: bytes) -> bytes:
        called.set()
        go.wait(10)
        return answer(b"never")

    session, thread = serving(pair[1], hang)
    pair[0].sendall(struct.pack("<I", 0))
    assert called.wait(20)
    session.finish()
    assert not session.join(0.02)
    assert pair[0].recv(100) == b""
    go.set()
    thread.join(20)
