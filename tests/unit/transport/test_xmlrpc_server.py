"""The XML-RPC server against raw sockets: replies to hostile and unusual peers."""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from typing import Any

import pytest

from rosproto.protocol import xmlrpc
from rosproto.protocol.http import HttpClientConnection, Response
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import xmlrpc_server
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import connect
from rosproto.transport.xmlrpc_server import Peer, XmlRpcServer
from tests.support.waiting import until

SOON = 20.0


def dispatch(method: str, params: list[object], peer: Peer) -> object:
    if method == "echo":
        return params
    if method == "peer":
        return [str(peer), peer.host, peer.port, peer.local_host]
    if method == "fault":
        raise xmlrpc.Fault(42, "asked for")
    if method == "bug":
        raise KeyError("a bug")
    if method == "unsendable":
        return 2**40
    raise xmlrpc.Fault(-32601, f"no method {method}")


@pytest.fixture
def server() -> Iterator[XmlRpcServer]:
    with XmlRpcServer("127.0.0.1", 0, dispatch, name="test") as running:
        yield running


class RawClient:
    """A socket and the client's side of HTTP, nothing more."""

    def __init__(self, server: XmlRpcServer) -> None:
        self.sock = connect("127.0.0.1", server.port, Deadline(SOON))
        self.sock.settimeout(SOON)
        self.http = HttpClientConnection(Limits())

    def __enter__(self) -> RawClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.sock.close()

    def receive(self) -> Response | None:
        """The next response; None when the server closed without one."""
        while True:
            event = self.http.next_event()
            if event is not None:
                return event if isinstance(event, Response) else None
            try:
                self.http.receive(self.sock.recv(65536))
            except ConnectionResetError:
                return None

    def ask(self, data: bytes) -> Response:
        self.sock.sendall(data)
        response = self.receive()
        assert response is not None
        return response

    def call(self, method: str, *params: object) -> object:
        response = self.ask(self.http.encode_request("h", "/", xmlrpc.encode_call(method, params)))
        assert response.status == 200
        return xmlrpc.decode_response(response.body)


def post(body: bytes, path: str = "/") -> bytes:
    return HttpClientConnection(Limits()).encode_request("h", path, body)


ECHO = xmlrpc.encode_call("echo", [1])


def test_a_call_is_answered_and_the_connection_kept(server: XmlRpcServer) -> None:
    with RawClient(server) as client:
        for value in (1, "two", [3.0]):
            assert client.call("echo", value) == [value]
    assert server.stats.accepted == 1


def test_the_uri_has_the_real_port_and_the_advertised_host() -> None:
    with XmlRpcServer("127.0.0.1", 0, dispatch, advertise="robot") as server:
        assert server.uri == f"http://robot:{server.port}/"
        assert server.port


def test_dispatch_learns_who_calls_and_at_which_address_of_ours(server: XmlRpcServer) -> None:
    with RawClient(server) as client:
        host, port = client.sock.getsockname()
        assert client.call("peer") == [f"{host}:{port}", host, port, "127.0.0.1"]


@pytest.mark.parametrize("path", ["/", "/RPC2", "/RPC2?x"])
def test_both_paths_are_served(server: XmlRpcServer, path: str) -> None:
    with RawClient(server) as client:
        assert client.ask(post(ECHO, path)).status == 200


@pytest.mark.promise("`/` and `/RPC2` are served, other paths are")
def test_another_path_is_404_and_the_connection_goes_on(server: XmlRpcServer) -> None:
    with RawClient(server) as client:
        assert client.ask(post(ECHO, "/foo")).status == 404
        assert client.call("echo", 1) == [1]


@pytest.mark.parametrize(("method", "status"), [("GET", 405), ("HEAD", 405), ("BREW", 501)])
def test_other_methods_are_refused(server: XmlRpcServer, method: str, status: int) -> None:
    with RawClient(server) as client:
        assert client.ask(f"{method} / HTTP/1.1\r\n\r\n".encode()).status == status
        assert client.receive() is None


def test_faults_cross_and_a_bug_in_the_handler_is_fault_1_and_logged(
    server: XmlRpcServer, caplog: pytest.LogCaptureFixture
) -> None:
    with RawClient(server) as client, caplog.at_level(logging.ERROR):
        for method, code, text in (
            ("fault", 42, "asked for"),
            ("bug", 1, "KeyError"),
            ("nothing", -32601, "nothing"),
        ):
            with pytest.raises(xmlrpc.Fault, match=text) as caught:
                client.call(method)
            assert caught.value.code == code
        assert client.call("echo") == []
    assert "bug from 127.0.0.1" in caplog.text


def test_a_result_that_cannot_be_sent_is_a_fault(server: XmlRpcServer) -> None:
    with RawClient(server) as client, pytest.raises(xmlrpc.Fault, match="32 bits"):
        client.call("unsendable")


def test_nonsense_in_the_body_is_a_fault_and_the_connection_goes_on(server: XmlRpcServer) -> None:
    with RawClient(server) as client:
        for body in (b"nonsense", b"<!DOCTYPE x><methodCall/>", b"<value>" * 1000, b"\xff"):
            response = client.ask(post(body))
            with pytest.raises(xmlrpc.Fault) as caught:
                xmlrpc.decode_response(response.body)
            assert caught.value.code == -32700
        assert client.call("echo", 1) == [1]


def test_multicall_gives_each_result_in_a_list_or_a_faults_struct(server: XmlRpcServer) -> None:
    calls = [
        {"methodName": "echo", "params": [1, 2]},
        {"methodName": "fault", "params": []},
        {"methodName": "unsendable"},
        {"methodName": "system.multicall", "params": [[]]},
        {"params": []},
        "nonsense",
        {"methodName": "echo", "params": "nonsense"},
        {"methodName": "echo"},
    ]
    with RawClient(server) as client:
        results = client.call("system.multicall", calls)
        assert isinstance(results, list)
        assert [result if isinstance(result, list) else result["faultCode"] for result in results] == [
            [[1, 2]],
            42,
            1,
            -32600,
            -32600,
            -32600,
            -32600,
            [[]],
        ]
        for wrong in ((), (1,), ([], [])):
            with pytest.raises(xmlrpc.Fault, match="array of calls"):
                client.call("system.multicall", *wrong)


def test_a_request_byte_by_byte_and_pipelined_requests_are_answered(server: XmlRpcServer) -> None:
    with RawClient(server) as client:
        for byte in post(ECHO):
            client.sock.send(bytes([byte]))
        response = client.receive()
        assert response is not None
        assert response.status == 200
        client.sock.sendall(post(ECHO) * 3)
        for _ in range(3):
            response = client.receive()
            assert response is not None
            assert xmlrpc.decode_response(response.body) == [1]


def test_expect_100_continue_gets_its_go_ahead(server: XmlRpcServer) -> None:
    head, body = post(ECHO).replace(b"Host", b"Expect: 100-continue\r\nHost").split(b"\r\n\r\n")
    with RawClient(server) as client:
        client.sock.sendall(head + b"\r\n\r\n")
        assert client.sock.recv(100) == b"HTTP/1.1 100 Continue\r\n\r\n"
        assert client.ask(body).status == 200


def test_a_chunked_request_is_answered(server: XmlRpcServer) -> None:
    with RawClient(server) as client:
        head = b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n"
        assert client.ask(head + b"%x\r\n%b\r\n0\r\n\r\n" % (len(ECHO), ECHO)).status == 200


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (b"nonsense\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\n\r\n", 411),
        (b"POST / HTTP/1.1\r\nContent-Length: 999999999\r\n\r\n" + b"x" * 200_000, 413),
        (b"POST / HTTP/1.1\r\nX: " + b"x" * 20_000, 431),
        (b"POST / HTTP/9.9\r\n\r\n", 505),
    ],
)
def test_a_refused_request_gets_its_status_and_the_end(
    server: XmlRpcServer, data: bytes, status: int
) -> None:
    with RawClient(server) as client:
        response = client.ask(data)
        assert (response.status, response.keep_alive) == (status, False)
        assert client.receive() is None


def test_http_1_0_without_keep_alive_is_closed_after_one_answer(server: XmlRpcServer) -> None:
    with RawClient(server) as client:
        response = client.ask(post(ECHO).replace(b"HTTP/1.1", b"HTTP/1.0"))
        assert not response.keep_alive
        assert client.receive() is None


@pytest.mark.parametrize("data", [b"", b"POST", post(ECHO)[:-1]])
def test_a_slow_request_ends_after_handshake_seconds(data: bytes) -> None:
    with (
        XmlRpcServer("127.0.0.1", 0, dispatch, limits=Limits(handshake_seconds=0.05)) as server,
        RawClient(server) as client,
    ):
        client.sock.sendall(data)
        start = time.monotonic()
        assert client.sock.recv(100) == b""
        assert time.monotonic() - start < SOON


def test_dripping_bytes_do_not_buy_time() -> None:
    with (
        XmlRpcServer("127.0.0.1", 0, dispatch, limits=Limits(handshake_seconds=0.2)) as server,
        RawClient(server) as client,
    ):
        client.sock.settimeout(0.01)
        end = time.monotonic() + SOON
        while True:
            assert time.monotonic() < end
            try:
                client.sock.send(b"P")
                if client.sock.recv(100) == b"":
                    break
            except TimeoutError:
                continue
            except OSError:
                break


@pytest.mark.promise("Connections are kept, closed when idle, and capped")
def test_idle_seconds_bounds_the_wait_for_a_next_request() -> None:
    with (
        XmlRpcServer("127.0.0.1", 0, dispatch, limits=Limits(idle_seconds=0.05)) as server,
        RawClient(server) as client,
    ):
        assert client.call("echo") == []
        assert client.sock.recv(100) == b""


def test_an_idle_connection_makes_room_for_a_new_one() -> None:
    with (
        XmlRpcServer("127.0.0.1", 0, dispatch, limits=Limits(connections=2)) as server,
        RawClient(server) as first,
        RawClient(server) as second,
    ):
        for number, client in enumerate((first, second), 1):
            assert client.call("echo") == []
            # Idle once the server waits for the next request.
            until(lambda count=number: len(server._server._idle) >= count, SOON, "an idle connection")  # type: ignore[misc]
        with RawClient(server) as third:
            assert third.call("echo") == []
            assert first.receive() is None
            assert second.call("echo") == []


def test_the_call_that_ends_the_server_is_answered() -> None:
    """As `rosnode kill` is: the end begins in another thread, and may be quicker than the answer."""
    ending: list[threading.Thread] = []

    def shut_down(method: str, params: list[object], peer: Peer) -> object:
        ending.append(threading.Thread(target=server.close))
        ending[0].start()
        ending[0].join(0.1)
        return [1, "shutdown", 0]

    server = XmlRpcServer("127.0.0.1", 0, shut_down)
    with RawClient(server) as client:
        assert client.call("shutdown") == [1, "shutdown", 0]
    ending[0].join(SOON)
    assert not ending[0].is_alive()


def test_slow_calls_do_not_hold_up_others_and_close_is_prompt() -> None:
    entered, release = threading.Event(), threading.Event()

    def slow(method: str, _params: list[object], _peer: str) -> object:
        if method == "slow":
            entered.set()
            release.wait(SOON)
        return 1

    with (
        XmlRpcServer("127.0.0.1", 0, slow, name="slowly") as server,
        RawClient(server) as one,
        RawClient(server) as other,
    ):
        one.sock.sendall(post(xmlrpc.encode_call("slow")))
        assert entered.wait(SOON)
        assert other.call("fast") == 1
        start = time.monotonic()
        server.close(timeout=0.05)
        assert time.monotonic() - start < SOON / 2
        release.set()
    until(
        lambda: not any(thread.name.startswith("rosproto:slowly") for thread in threading.enumerate()),
        SOON,
        "the end of the thread",
    )


def test_a_peer_that_does_not_read_its_answer_costs_its_own_connection_only() -> None:
    answer = "x" * 8_000_000
    limits = Limits(handshake_seconds=1.0, xml_body_bytes=1 << 25)  # `other` has that long to ask, too
    with (
        XmlRpcServer(
            "127.0.0.1", 0, lambda m, _p, _peer: answer if m == "big" else 1, limits=limits
        ) as server,
        RawClient(server) as deaf,
        RawClient(server) as other,
    ):
        deaf.sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.sock.sendall(post(xmlrpc.encode_call("big")))
        assert other.call("small") == 1
        until(lambda: server.connections <= 1, SOON, "the end of the deaf one")


def test_a_flood_of_silent_connections_keeps_nobody_out() -> None:
    with XmlRpcServer("127.0.0.1", 0, dispatch, limits=Limits(pending_handshakes=5)) as server:
        silent = [RawClient(server) for _ in range(40)]
        with RawClient(server) as client:
            assert client.call("echo") == []
            for each in silent:
                each.sock.close()
            assert client.call("echo") == []
        assert server.stats.dropped_pending >= 35


def test_a_reset_in_the_middle_is_silent(server: XmlRpcServer, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        for data in (b"", b"POST / HT", post(ECHO)):
            client = RawClient(server)
            client.sock.sendall(data)
            client.sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            client.sock.close()
        with RawClient(server) as client:
            assert client.call("echo") == []
    assert not caplog.records


@pytest.mark.promise("`allow=` takes a list of addresses")
def test_peers_that_are_not_allowed_get_nothing() -> None:
    with XmlRpcServer("127.0.0.1", 0, dispatch, allow=["10.0.0.7"]) as server, RawClient(server) as client:
        try:
            client.sock.sendall(post(ECHO))
        except OSError:
            return  # closed before we could even ask
        assert client.receive() is None


def test_a_peer_that_comes_during_the_start_is_answered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes hammer the port of a master that restarts: the first of them met a server without its attributes."""
    early: list[socket.socket] = []

    class Slow(xmlrpc_server.TcpServer):
        """Its caller gets it only after a peer had time to be served."""

        def __init__(self, *args: Any, **options: Any) -> None:
            super().__init__(*args, **options)
            early.append(connect("127.0.0.1", self.port, Deadline(SOON)))
            early[0].sendall(post(ECHO))
            early[0].settimeout(0.2)
            with pytest.raises(TimeoutError):
                early[0].recv(1)

    monkeypatch.setattr(xmlrpc_server, "TcpServer", Slow)
    with XmlRpcServer("127.0.0.1", 0, dispatch, name="young"), early[0] as sock:
        sock.settimeout(SOON)
        assert sock.recv(15) == b"HTTP/1.1 200 OK"


@pytest.mark.promise("answers large XML-RPC requests one at a time")
def test_large_requests_wait_for_each_other_and_hold_up_no_small_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thread waits for every other running one whenever it continues; a dozen large ones took 20 seconds."""
    running, go = threading.Semaphore(0), threading.Event()
    at_once: list[int] = []
    lock = threading.Lock()
    now = 0

    def answer(method: str, params: list[object], peer: Peer) -> object:
        nonlocal now
        if method == "small":
            return "small"
        with lock:
            now += 1
            at_once.append(now)
        running.release()
        assert go.wait(SOON)
        with lock:
            now -= 1
        return len(str(params[0]))

    monkeypatch.setattr(xmlrpc_server, "_LARGE_BYTES", 1000)
    with XmlRpcServer("127.0.0.1", 0, answer, name="test") as server:
        peer = Peer("x")
        large = xmlrpc.encode_call("large", ["x" * 2000])
        answers: list[bytes] = []
        threads = [
            threading.Thread(target=lambda: answers.append(server.answer(large, peer))) for _ in range(4)
        ]
        for thread in threads:
            thread.start()
        try:
            assert running.acquire(timeout=SOON)
            assert b"small" in server.answer(xmlrpc.encode_call("small", []), peer)
            assert at_once == [1]
        finally:
            go.set()
            for thread in threads:
                thread.join(SOON)
        assert at_once == [1] * 4
        assert len(set(answers)) == 1
        assert b"2000" in answers[0]


def test_a_large_request_does_not_wait_for_ever() -> None:
    """It gets a fault when another one takes too long."""
    begun, go = threading.Event(), threading.Event()

    def answer(method: str, params: list[object], peer: Peer) -> object:
        begun.set()
        return go.wait(SOON)

    with XmlRpcServer("127.0.0.1", 0, answer, name="test", limits=Limits(idle_seconds=0.05)) as server:
        large = xmlrpc.encode_call("large", ["x" * (1 << 20)])
        first = threading.Thread(target=server.answer, args=(large, Peer("x")))
        first.start()
        try:
            assert begun.wait(SOON)
            assert b"try again later" in server.answer(large, Peer("x"))
        finally:
            go.set()
            first.join(SOON)
        assert b"try again later" not in server.answer(large, Peer("x"))


@pytest.mark.promise(
    "It makes large replies one at a time", "keep other large replies waiting, small ones not"
)
def test_large_replies_that_nobody_reads_keep_no_more_than_their_budget(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each client of many could have a large parameter sent and not read it. Small calls go on meanwhile."""
    made: list[int] = []
    encode = xmlrpc.encode_response

    def encode_response(value: object) -> bytes:
        reply = encode(value)
        if len(reply) > 1 << 20:
            made.append(len(reply))
        return reply

    def answer(method: str, params: list[object], peer: Peer) -> object:
        return "x" * (12 << 20) if method == "large" else "small"

    monkeypatch.setattr(xmlrpc, "encode_response", encode_response)
    monkeypatch.setattr(xmlrpc_server, "_MAX_REPLY_BYTES", 16 << 20)
    with XmlRpcServer("127.0.0.1", 0, answer, name="test") as server, ExitStack() as stack:
        clients = [stack.enter_context(RawClient(server)) for _ in range(6)]
        for client in clients:
            client.sock.sendall(client.http.encode_request("h", "/", xmlrpc.encode_call("large", [])))
        until(lambda: len(made) == 2)  # the second one when there was room for a part of it
        for _ in range(3):
            assert b"small" in server.answer(xmlrpc.encode_call("small", []), Peer("x"))
        assert len(made) == 2
        with ThreadPoolExecutor(len(clients)) as pool:
            for response in pool.map(RawClient.receive, clients):
                assert response is not None
                assert len(response.body) > 12 << 20
        assert len(made) == 6


def test_a_reply_that_is_too_large_and_one_that_waits_too_long_are_faults(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def answer(method: str, params: list[object], peer: Peer) -> object:
        return ["x" * 3000] * (3 if method == "huge" else 1)

    monkeypatch.setattr(xmlrpc_server, "_LARGE_BYTES", 1000)
    monkeypatch.setattr(xmlrpc_server, "_MAX_REPLY_BYTES", 4000)
    with XmlRpcServer("127.0.0.1", 0, answer, name="test", limits=Limits(idle_seconds=0.05)) as server:
        large, peer = xmlrpc.encode_call("large", []), Peer("x")
        assert b"ask for parts of it" in server.answer(xmlrpc.encode_call("huge", []), peer)
        replies = [server.answer(large, peer) for _ in range(2)]
        assert b"try again later" in server.answer(large, peer)
        server.sent(replies[0])
        assert b"xxx" in server.answer(large, peer)
