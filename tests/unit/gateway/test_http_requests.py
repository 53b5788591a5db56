"""Requests by POST on the port of a WebSocket server: what is answered, refused and bounded, by raw sockets."""

from __future__ import annotations

import asyncio
import base64
import gc
import json
import socket
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from http import HTTPStatus
from typing import Any

import pytest

from rosproto.gateway import ClientChannel, GatewayLimits, HandshakeRules, WebSocketServer, http_requests
from rosproto.protocol.http import HttpServerConnection
from rosproto.protocol.wire_limits import Limits
from tests.support.extras import needs
from tests.support.waiting import until

needs("api")

TOKEN = "kd83-hsa2"
LIMITS = GatewayLimits(message_bytes=5000, handshake_seconds=2.0, close_seconds=1.0)
Start = Callable[..., WebSocketServer]


class Echo:
    """A handler that says what it was given; some paths do something else."""

    def __init__(self) -> None:
        self.may_answer = threading.Event()
        self.asked: list[str] = []

    async def answer(self, path: str, data: bytes, address: str) -> tuple[HTTPStatus, str]:
        self.asked.append(path)
        while path == "/wait" and not self.may_answer.is_set():
            await asyncio.sleep(0.01)
        if path == "/long":
            return HTTPStatus.OK, json.dumps("x" * (16 << 20))
        assert path != "/broken", "a planted error"
        return HTTPStatus.OK, json.dumps([path, data.decode(), address])

    def refused(self, why: str) -> str:
        return json.dumps({"why": why})


class Session:
    """A client by WebSocket; it answers with what it was sent."""

    max_message_bytes = 5000

    def __init__(self, channel: ClientChannel) -> None:
        self.channel = channel

    async def received(self, data: str | bytes) -> None:
        self.channel.answer((data,))

    def ended(self) -> None:
        pass


@pytest.fixture
def handler() -> Iterator[Echo]:
    made = Echo()
    yield made
    made.may_answer.set()


@pytest.fixture
def start(handler: Echo) -> Iterator[Start]:
    with ExitStack() as stack:

        def begin(limits: GatewayLimits = LIMITS, **rules: Any) -> WebSocketServer:
            made = WebSocketServer(
                Session, HandshakeRules("127.0.0.1", **rules), limits=limits, name="robot-api", posts=handler
            )
            stack.callback(made.close)
            return made

        yield begin


class Http:
    """One connection, by hand."""

    def __init__(self, server: WebSocketServer) -> None:
        self.sock = socket.create_connection(("127.0.0.1", server.port), 20.0)
        self.lines = self.sock.makefile("rb")

    def __enter__(self) -> Http:
        return self

    def __exit__(self, *_: object) -> None:
        self.lines.close()
        self.sock.close()

    def send(self, data: bytes) -> None:
        self.sock.sendall(data)

    def answer(self) -> tuple[int, dict[str, str], Any]:
        """Status, headers and JSON of the next answer; status 0 at the end of the connection."""
        line = self.lines.readline()
        if not line:
            return 0, {}, None
        headers = {}
        while (field := self.lines.readline().strip().decode()) != "":
            name, _, value = field.partition(": ")
            headers[name.lower()] = value
        body = self.lines.read(int(headers["content-length"]))
        return int(line.split()[1]), headers, json.loads(body)


def post(path: str = "/a", body: bytes = b"{}", *headers: str, version: str = "1.1") -> bytes:
    """The bytes of a request."""
    lines = [f"POST {path} HTTP/{version}", f"Content-Length: {len(body)}", *headers]
    if not any(header.lower().startswith("host") for header in headers):
        lines.append("Host: 127.0.0.1")
    return "\r\n".join([*lines, "", ""]).encode() + body


def asked(server: WebSocketServer, data: bytes) -> tuple[int, dict[str, str], Any]:
    with Http(server) as client:
        client.send(data)
        return client.answer()


# -- what is answered ----------------------------------------------------------------------------------------


def test_requests_are_answered_on_a_kept_connection(start: Start) -> None:
    with Http(start()) as client:
        for number in range(100):
            client.send(post(f"/{number}?a=b", b'{"n":%d}' % number))
            status, headers, body = client.answer()
            assert (status, headers["content-type"]) == (200, "application/json")
            assert (headers["connection"], body) == (
                "keep-alive",
                [f"/{number}", f'{{"n":{number}}}', "127.0.0.1"],
            )


@pytest.mark.parametrize(
    ("data", "kept"),
    [
        (post(version="1.0"), False),
        (post("/a", b"{}", "Connection: keep-alive", version="1.0"), True),
        (post("/a", b"{}", "Connection: close"), False),
        (post("/a", b"{}", "Content-Type: text/plain"), True),
        (post("/a", b"{}", "Host: localhost:5480"), True),
        (b"\r\n" + post(), True),
        (b"POST /a HTTP/1.1\nHost: [::1]\ncontent-length: 2\n\n{}", True),
        (
            b"POST /a HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n1\r\n{\r\n1\r\n}\r\n0\r\n\r\n",
            True,
        ),
        (post("http://127.0.0.1:5480/a"), True),
    ],
)
@pytest.mark.parametrize("whole", [True, False])
def test_clients_of_many_kinds_are_answered(start: Start, data: bytes, kept: bool, whole: bool) -> None:
    """HTTP/1.0, bare newlines, chunks; whole or byte by byte."""
    with Http(start()) as client:
        for piece in [data] if whole else [data[at : at + 1] for at in range(len(data))]:
            client.send(piece)
        assert client.answer()[::2] == (200, ["/a", "{}", "127.0.0.1"])
        client.send(post("/again") if kept else b"")
        assert client.answer()[0] == (200 if kept else 0)


def test_requests_in_a_row_are_answered_in_their_order(start: Start, handler: Echo) -> None:
    """The next one is not begun before the one before is answered."""
    with Http(start()) as client:
        client.send(b"".join(post(f"/{number}") for number in range(500)))
        assert [client.answer()[2][0] for _ in range(500)] == [f"/{number}" for number in range(500)]
        client.send(post("/wait") + post("/after"))
        until(lambda: "/wait" in handler.asked)
        assert "/after" not in handler.asked
        handler.may_answer.set()
        assert [client.answer()[2][0] for _ in range(2)] == ["/wait", "/after"]


def test_a_client_that_waits_for_the_body_to_be_wanted_is_told_to_go_on(start: Start) -> None:
    head, body = post("/a", b"{}", "Expect: 100-continue").split(b"\r\n\r\n")
    with Http(start()) as client:
        client.send(head + b"\r\n\r\n")
        assert client.lines.readline() + client.lines.readline() == b"HTTP/1.1 100 Continue\r\n\r\n"
        client.send(body)
        assert client.answer()[0] == 200


def test_a_request_that_waits_keeps_nobody_else_waiting(start: Start, handler: Echo) -> None:
    server = start()
    with Http(server) as slow:
        slow.send(post("/wait"))
        until(lambda: "/wait" in handler.asked)
        assert asked(server, post())[0] == 200
        handler.may_answer.set()
        assert slow.answer()[0] == 200


def test_the_same_port_speaks_websocket(start: Start) -> None:
    """Also if the first bytes come one by one."""
    from tests.support.websocket import connect

    server = start()
    with connect(server.url) as client:
        assert asked(server, post())[0] == 200
        client.send("hello")
        assert client.recv(20.0) == "hello"
    request = (
        "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Key: {base64.b64encode(bytes(16)).decode()}\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    with Http(server) as client:
        for letter in request.encode():
            client.send(bytes([letter]))
        assert client.lines.readline() == b"HTTP/1.1 101 Switching Protocols\r\n"
    until(lambda: server.accepted == 2)
    with Http(server) as client:
        client.send(b"GET /a HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        assert client.lines.readline().startswith(b"HTTP/1.1 426 ")


# -- what is refused -----------------------------------------------------------------------------------------


JSON = "Content-Type: application/json"


@pytest.mark.promise("answers requests by POST, too, by the same rules")
@pytest.mark.parametrize(
    ("headers", "status"),
    [
        (["Origin: https://evil.example", JSON], 403),
        (["Origin: http://localhost:8080", JSON], 403),
        (["Origin: null", JSON], 403),
        (["Origin: http://127.0.0.1:1", JSON, "Host: 127.0.0.1:2"], 403),
        (["Sec-Fetch-Site: cross-site", JSON], 403),
        (["Origin: http://127.0.0.1", "Content-Type: text/plain"], 415),
        (["Origin: http://127.0.0.1", "Content-Type: application/x-www-form-urlencoded"], 415),
        (["Origin: http://127.0.0.1", "Content-Type: text/plain; application/json"], 415),
        (["Origin: http://127.0.0.1"], 415),
        (["Origin: http://127.0.0.1", "Content-Type: Application/JSON; charset=utf-8"], 200),
        (["Host: evil.example"], 421),
        (["Host: evil.example:5480", "Origin: http://evil.example:5480", JSON], 421),
        (["Host: 127.0.0.1", "Host: evil.example"], 421),
        (["Host: "], 421),
    ],
)
def test_a_page_of_another_site_moves_nothing(
    start: Start, handler: Echo, headers: list[str], status: int
) -> None:
    """Neither by a script nor by a form, which no browser asks about before it sends it."""
    found, answered, body = asked(start(), post("/a", b"{}", *headers))
    assert (found, answered["content-type"]) == (status, "application/json")
    assert "access-control-allow-origin" not in answered
    assert status == 200 or body["why"]
    assert handler.asked == (["/a"] if status == 200 else [])


@pytest.mark.promise("ten seconds from its first byte to its last, and a status for an answer")
@pytest.mark.parametrize(
    ("data", "status", "says"),
    [
        (b"POST /a HTTP/1.1\r\nHost: localhost\r\n\r\n", 411, "without Content-Length"),
        (post("/a", b"x" * 5001), 413, "may have 5000 bytes"),
        (b"POST /a HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n", 413, "may have 5000 bytes"),
        (
            b"POST /a HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nffffffffffff\r\n",
            413,
            "may have 5000 bytes",
        ),
        (b"POST /a HTTP/1.1\r\nTransfer-Encoding: gzip\r\n\r\n", 501, "only chunked is known"),
        (b"POST /a HTTP/1.1\r\nTransfer-Encoding: chunked\r\nContent-Length: 2\r\n\r\n{}", 400, "both"),
        (b"POST /a HTTP/1.1\r\nContent-Length: 2\r\nContent-Length: 3\r\n\r\n{}", 400, "two different"),
        (b"POST /a HTTP/1.1\r\nContent-Length: -2\r\n\r\n{}", 400, "is not a number"),
        (b"POST /a HTTP/1.1\r\nContent-Length: 2, 2\r\n\r\n{}", 400, "is not a number"),
        (b"POST /a HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nxyz\r\n", 400, "not a hexadecimal number"),
        (b"POST /a HTTP/1.1\r\nX: " + b"x" * 20_000 + b"\r\n\r\n", 431, "may have 16384 bytes"),
        (b"x" * 20_000, 431, "may have 16384 bytes"),
        (b"POST /a HTTP/1.1\r\nno colon\r\n\r\n", 400, "expected 'Name: value'"),
        (b"POST /a HTTP/1.1\r\n folded: x\r\n\r\n", 400, "expected 'Name: value'"),
        (b"POST\r\n\r\n", 400, "request line"),
        (b"\x16\x03\x01\x02\x00\r\n\r\n", 400, "request line"),
        (b"POST /a HTTP/3\r\nContent-Length: 0\r\n\r\n", 505, "expected HTTP/1.1"),
        (b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 505, "expected HTTP/1.1"),
        (post("/a", b"{}", "Expect: the unexpected"), 417, "Expect"),
        (post().replace(b"POST", b"PUT"), 405, "and not PUT"),
        (b"OPTIONS * HTTP/1.1\r\nHost: localhost\r\n\r\n", 405, "and not OPTIONS"),
        (b"GETT / HTTP/1.1\r\nHost: localhost\r\n\r\n", 405, "and not GETT"),
        (post("/broken"), 500, "internal error"),
    ],
)
def test_what_is_not_a_request_is_refused_with_a_status_and_a_sentence(
    start: Start, data: bytes, status: int, says: str
) -> None:
    """And its connection ends; the next one is answered."""
    server = start()
    with Http(server) as client:
        client.send(data)
        found, headers, body = client.answer()
        assert (found, headers["connection"], says in body["why"]) == (status, "close", True), body
        assert (headers.get("allow") == "POST") is (status == 405)
        assert client.answer()[0] == 0
    assert asked(server, post())[0] == 200


def test_a_refused_client_that_goes_on_sending_still_gets_its_answer(start: Start) -> None:
    """To close at once would reset its connection."""
    with Http(start()) as client:
        client.send(b"POST /a HTTP/1.1\r\nContent-Length: 1000000\r\n\r\n")
        with suppress(OSError):
            for _ in range(100):
                client.send(b"x" * 10_000)
        assert client.answer()[0] == 413


@pytest.mark.promise("the password of Basic authentication")
def test_the_token_may_be_the_password_of_basic_authentication(start: Start, handler: Echo) -> None:
    """Beside `Bearer` and the address; of a program that knows no tokens. Any name will do."""

    def basic(pair: str) -> str:
        return f"Authorization: Basic {base64.b64encode(pair.encode()).decode()}"

    server = start(token=TOKEN)
    for headers in ([basic(f"robot:{TOKEN}")], [basic(f":{TOKEN}")], [f"Authorization: Bearer {TOKEN}"]):
        assert asked(server, post("/a", b"{}", *headers))[0] == 200
    assert asked(server, post(f"/a?token={TOKEN}"))[0] == 200
    handler.asked.clear()
    for headers in (
        [],
        [basic("robot:wrong")],
        [basic(TOKEN)],
        [basic(f"{TOKEN}:")],
        ["Authorization: Basic !"],
        [f"Authorization: Basic {TOKEN}"],
        [basic(f"robot:{TOKEN}"), basic("robot:wrong")],
    ):
        assert asked(server, post("/a", b"{}", *headers))[0] == 401
    assert handler.asked == []


# -- what is bounded -----------------------------------------------------------------------------------------


@pytest.mark.promise("ten seconds from its first byte to its last, and a status for an answer")
def test_a_slow_request_ends(start: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a status. Its time runs from its first byte, on a kept connection as well, whatever it sends."""
    monkeypatch.setattr(http_requests, "REQUEST_SECONDS", 0.3)
    server = start()
    with Http(server) as client:
        client.send(post())
        assert client.answer()[0] == 200
        began = time.monotonic()
        client.send(post()[:-1])
        status, _, body = client.answer()
        assert (status, "not complete after 0.3 s" in body["why"]) == (408, True)
        assert time.monotonic() - began < 10.0
        assert client.answer()[0] == 0
    with Http(server) as client:  # a byte now and then does not help
        over = threading.Event()

        def drip() -> None:
            with suppress(OSError):
                for letter in post(body=b"x" * 4000):
                    client.send(bytes([letter]))
                    if over.wait(0.02):
                        return

        thread = threading.Thread(target=drip)
        thread.start()
        try:
            assert client.answer()[0] == 408
        finally:
            over.set()
            thread.join(10.0)
    assert server.refused["request"] == 2


@pytest.mark.parametrize("begun", [b"", b"G", b"GET"])
def test_a_connection_that_does_not_say_what_it_speaks_ends(start: Start, begun: bytes) -> None:
    server = start(LIMITS._replace(handshake_seconds=0.3))
    with Http(server) as client:
        client.send(begun)
        with suppress(ConnectionError):
            assert client.answer()[0] == 0


@pytest.mark.promise("an idle connection ends after 20 seconds")
def test_an_idle_connection_ends(start: Start) -> None:
    server = start(LIMITS._replace(silence_seconds=0.3))
    with Http(server) as client:
        client.send(post())
        assert client.answer()[0] == 200
        with suppress(ConnectionError):
            assert client.answer()[0] == 0
    until(lambda: not len(server.slots))
    assert server.refused == {}, "it had asked, so it is not a missing handshake"


def test_an_answer_that_is_not_read_ends_its_connection(start: Start) -> None:
    server = start(LIMITS._replace(silence_seconds=0.3))
    with Http(server) as client:
        client.send(post("/long") * 20)
        until(lambda: server.stalled == 1)
        assert asked(server, post())[0] == 200


def test_a_long_answer_is_not_cut(start: Start) -> None:
    with Http(start()) as client:
        client.send(post("/long", b"{}", "Connection: close"))
        assert len(client.answer()[2]) == 16 << 20


@pytest.mark.promise("All connections by HTTP together are bounded")
def test_a_connection_that_waits_for_its_answer_is_not_replaced(start: Start, handler: Echo) -> None:
    """Others are, the longest silent one first; so a crowd costs a bounded number of connections."""
    server = start(LIMITS._replace(pending_handshakes=10))
    with ExitStack() as stack:
        slow = stack.enter_context(Http(server))
        slow.send(post("/wait"))
        until(lambda: "/wait" in handler.asked)
        for _ in range(30):
            stack.enter_context(Http(server)).send(b"POST /a HTTP/1.1\r\n")
        until(lambda: server.refused["too many handshakes at a time"] >= 21)
        assert len(server.slots) <= 10
        assert asked(server, post())[0] == 200
        handler.may_answer.set()
        assert slow.answer()[0] == 200


def test_what_a_connection_has_sent_is_freed_with_it(start: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    """At once, and not when Python next looks for cycles: a crowd that comes and goes would fill the memory."""
    made: list[weakref.ref[HttpServerConnection]] = []

    class Watched(HttpServerConnection):
        def __init__(self, limits: Limits) -> None:
            super().__init__(limits)
            made.append(weakref.ref(self))

    monkeypatch.setattr(http_requests, "HttpServerConnection", Watched)
    server = start()
    gc.disable()
    try:
        for _ in range(20):
            with Http(server) as client:
                client.send(post(body=b"x" * 4000)[:-1])
        until(
            lambda: (
                len(made) >= 20
                and not any(one is not None and one.mid_message for one in [each() for each in made])
            )
        )
    finally:
        gc.enable()


@pytest.mark.promise("All connections by HTTP together are bounded")
def test_requests_that_wait_lock_nobody_out(start: Start, handler: Echo) -> None:
    """However many of them are answered slowly: a new one may be a stop."""
    from tests.support.websocket import connect

    server = start(LIMITS._replace(pending_handshakes=16))
    with ExitStack() as stack:
        for number in range(1, 40):
            stack.enter_context(Http(server)).send(post("/wait"))
            until(lambda number=number: len(handler.asked) == number)
        assert asked(server, post())[0] == 200
        with connect(server.url) as client:
            client.send("hello")
            assert client.recv(20.0) == "hello"


def test_a_server_closes_in_bounded_time(start: Start, handler: Echo) -> None:
    """While requests wait, connections are idle, and bodies are half there."""
    server = start()
    with ExitStack() as stack:
        for data in (post("/wait"), post(), post()[:-1], b"", b"GE"):
            client = stack.enter_context(Http(server))
            client.send(data)
        until(lambda: {"/wait", "/a"} <= set(handler.asked))
        began = time.monotonic()
        server.close()
        assert time.monotonic() - began < 5.0
