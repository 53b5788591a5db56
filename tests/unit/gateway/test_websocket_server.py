"""The WebSocket server: refused connections, clients that do not read, hundreds that connect and leave."""

from __future__ import annotations

import asyncio
import base64
import gc
import json
import os
import socket
import ssl
import struct
import sys
import threading
import time
from asyncio.trsock import TransportSocket
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import ExitStack, suppress
from typing import Any

import pytest

from rosproto.codec import message_class, service_class
from rosproto.errors import ConnectionLost
from rosproto.gateway import GatewayLimits
from rosproto.gateway.handshake import HandshakeRules
from tests.support.certificates import certificate
from tests.support.extras import needs
from tests.support.rosbridge_client import RosbridgeClient
from tests.unit.gateway.conftest import Graph

String = message_class("std_msgs/String")
Serve = Callable[..., Any]


def until(holds: Callable[[], bool], seconds: float = 10.0) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline, "it did not become true"
        threading.Event().wait(0.01)


def asked(bridge: Any, *headers: str, path: str = "/") -> str:
    """The status line that a handshake with these headers gets."""
    lines = [
        f"GET {path} HTTP/1.1",
        "Upgrade: websocket",
        "Connection: Upgrade",
        "Sec-WebSocket-Key: " + base64.b64encode(b"0123456789abcdef").decode(),
        "Sec-WebSocket-Version: 13",
        *headers,
    ]
    if not any(header.startswith("Host") for header in headers):
        lines.append(f"Host: 127.0.0.1:{bridge.port}")
    with socket.create_connection(("127.0.0.1", bridge.port), 10) as sock:
        sock.sendall("\r\n".join([*lines, "", ""]).encode())
        return sock.makefile("rb").readline().decode().strip()


def test_refused_handshakes_are_counted_by_reason(serve: Serve) -> None:
    """What is refused is tried at every door by tests/scenarios/test_doors.py."""
    bridge = serve(origins=["https://studio.example"])
    assert " 101 " in asked(bridge) + " "
    assert " 101 " in asked(bridge, "Origin: https://studio.example") + " "
    for origin in ("http://localhost:8080", "null", "https://studio.example.evil.com", "file://"):
        assert " 403 " in asked(bridge, f"Origin: {origin}")
    assert " 421 " in asked(bridge, "Host: evil.com:9090")
    assert " 400 " in asked(bridge, "Origin: http://localhost", "Origin: http://evil.com")
    assert bridge.stats().refused == {"origin": 4, "host": 1, "headers": 1}
    assert bridge.stats().accepted == 2


def test_tokens(serve: Serve) -> None:
    """In the address or in a header; none, a wrong one and two are none."""
    bridge = serve(token="s3cret&more%")
    assert " 101 " in asked(bridge, "Authorization: Bearer s3cret&more%") + " "
    assert " 101 " in asked(bridge, path="/?token=s3cret%26more%25") + " "
    for path in (
        "/",
        "/?token=",
        "/?token=s3cret",
        "/?token=s3cret%26more%25&token=x",
        "/?" + "a=1&" * 200,
    ):
        assert " 401 " in asked(bridge, path=path)
    assert " 401 " in asked(bridge, "Authorization: Basic s3cret&more%")
    assert " 401 " in asked(bridge, "Authorization: Bearer x", path="/?token=s3cret%26more%25")
    assert bridge.stats().refused == {"token": 5, "wrong-token": 2}


def test_a_port_that_is_taken(serve: Serve) -> None:
    """Is an error of the start, not of a thread."""
    from rosproto.gateway.websocket_server import WebSocketServer

    bridge = serve()
    with pytest.raises(ConnectionLost, match="port"):
        WebSocketServer(Idle, HandshakeRules("127.0.0.1"), port=bridge.port)
    assert len([t for t in threading.enumerate() if t.name == "rosproto:gateway"]) == 0


def test_tls(serve: Serve, graph: Graph, tmp_path: Any) -> None:
    """wss, with the certificate given; who speaks plainly there gets nothing."""
    cryptography = pytest.importorskip("cryptography")
    assert cryptography
    cert, key = certificate(tmp_path)
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.load_cert_chain(cert, key)
    bridge = serve(tls=context)
    assert bridge.url.startswith("wss://127.0.0.1:")
    trust = ssl.create_default_context(cafile=cert)
    with RosbridgeClient(bridge.url.replace("127.0.0.1", "localhost"), ssl=trust) as client:
        assert client.call("/rosapi/get_time")["result"]
    with socket.create_connection(("127.0.0.1", bridge.port), 10) as sock:
        sock.sendall(b"GET / HTTP/1.1\r\n\r\n")
        sock.settimeout(10)
        assert not sock.recv(100).startswith(b"HTTP")


def test_more_clients_than_allowed(serve: Serve) -> None:
    """Further clients are refused with the reason; connected ones stay."""
    bridge = serve(limits=GatewayLimits(connections=2))
    with RosbridgeClient(bridge.url) as one, RosbridgeClient(bridge.url):
        assert " 503 " in asked(bridge)
        assert one.call("/rosapi/get_time")["result"]
    until(lambda: not bridge.clients)
    with RosbridgeClient(bridge.url) as again:
        assert again.call("/rosapi/get_time")["result"]


@pytest.mark.promise("connection replaces the longest silent one")
def test_connections_that_say_nothing_make_room_and_are_ended(serve: Serve) -> None:
    """The one that holds back longest goes first; the others when their time is over."""
    bridge = serve(limits=GatewayLimits(pending_handshakes=3, handshake_seconds=0.5))
    silent = [socket.create_connection(("127.0.0.1", bridge.port), 10) for _ in range(10)]
    with RosbridgeClient(bridge.url) as client:
        assert client.call("/rosapi/get_time")["result"]
    for sock in silent:
        sock.settimeout(10)
        try:
            while sock.recv(1000):
                pass
        except ConnectionResetError:
            pass
        sock.close()
    assert bridge.stats().refused["too many handshakes at a time"] >= 7


class Idle:
    """A session that does nothing."""

    max_message_bytes = 1000

    def __init__(self, channel: Any) -> None: ...
    async def received(self, data: str | bytes) -> None: ...
    def ended(self) -> None: ...


HALF = b"GET / HTTP/1.1\r\nHost: localhost\r\n"
UPGRADE = (
    b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n"
    b"Sec-WebSocket-Version: 13\r\n\r\n"
)


def half_open(port: int, address: str = "127.0.0.1") -> socket.socket:
    """A connection from this address with half a request."""
    sock = socket.create_connection(("127.0.0.1", port), 10, (address, 0))
    sock.sendall(HALF)
    return sock


@pytest.mark.promise("So one address locks nobody else out")
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has all of 127.0.0.0/8")
def test_half_requests_of_one_address_lock_no_other_out(serve: Serve) -> None:
    """However many come, and though a viewer elsewhere takes its time for the handshake."""
    bridge = serve(limits=GatewayLimits(pending_handshakes=8))
    with ExitStack() as stack:
        viewer = stack.enter_context(half_open(bridge.port, "127.0.0.2"))
        for _ in range(100):
            stack.enter_context(half_open(bridge.port))
        until(lambda: bridge.stats().refused.get("too many handshakes at a time", 0) >= 93)
        viewer.sendall(UPGRADE)
        assert viewer.makefile("rb").readline().split()[1] == b"101"


@pytest.mark.promise("a request that comes at once is read before ten later connections replace it")
def test_a_crowd_that_comes_at_once_pushes_no_request_out() -> None:
    """From as many addresses as there are; all of them wait when the loop gets its turn."""
    pytest.importorskip("websockets", reason='websockets is not installed: pip install ".[bridge]"')
    from rosproto.gateway.websocket_server import WebSocketServer

    busy, go_on = threading.Event(), threading.Event()

    class Session(Idle):
        def __init__(self, channel: Any) -> None:
            busy.set()
            go_on.wait(20)

    limits = GatewayLimits(pending_handshakes=10)
    server = WebSocketServer(Session, HandshakeRules("127.0.0.1"), limits=limits)
    with ExitStack() as stack:
        stack.callback(server.close)
        stack.callback(go_on.set)
        stack.enter_context(opened(server))
        assert busy.wait(10)
        viewer = stack.enter_context(opened(server))
        for number in range(100):
            stack.enter_context(
                half_open(server.port, f"127.0.0.{2 + number}" if sys.platform == "linux" else "127.0.0.1")
            )
        go_on.set()
        assert viewer.makefile("rb").readline().split()[1] == b"101"


@pytest.mark.promise("half a TLS handshake, half a request, or a refusal that is not read")
def test_what_is_not_read_before_and_after_a_request_makes_room_too(serve: Serve, tmp_path: Any) -> None:
    """Half a TLS handshake, and the answer to a request that was refused."""
    pytest.importorskip("cryptography")
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.load_cert_chain(*certificate(tmp_path))
    for options, sent in (
        ({"tls": context}, b"\x16\x03\x01\x02\x00\x01"),
        ({"token": "kd83-hsa2"}, HALF + UPGRADE),
    ):
        bridge = serve(
            limits=GatewayLimits(pending_handshakes=4, handshake_seconds=60, close_seconds=60), **options
        )
        with ExitStack() as stack:
            for _ in range(20):
                sock = stack.enter_context(socket.create_connection(("127.0.0.1", bridge.port), 10))
                sock.sendall(sent)
            until(lambda b=bridge: b.stats().refused.get("too many handshakes at a time") == 16)


@pytest.mark.promise("A message has 4096 fragments at most")
def test_fragments_without_end_are_cut_off(serve: Serve) -> None:
    """Empty ones, which no limit of bytes sees; a message in 4096 fragments is read."""
    bridge = serve()
    first, empty, last = b"\x01\x82\0\0\0\0{}", b"\x00\x80\0\0\0\0", b"\x80\x80\0\0\0\0"
    with RosbridgeClient(bridge.url) as client:
        client.socket.sendall(first + empty * 4094 + last)
        assert "the message has no op" in client.op("status")["msg"]
        client.socket.sendall(first + empty * 4096)
        assert client.closed() == (1009, "a message may have 4096 fragments")


def test_nothing_is_written_to_a_client_that_is_gone(serve: Serve, caplog: pytest.LogCaptureFixture) -> None:
    """asyncio writes a line for each such write: here for the answers to pings that were sent before."""
    bridge = serve()
    for _ in range(10):
        sock = opened(bridge)
        until(lambda: len(bridge.clients) == 1)
        sock.sendall(b"\x89\x80\0\0\0\0" * 20_000)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        sock.close()
        until(lambda: not bridge.clients)
    assert [record.getMessage() for record in caplog.records if record.name == "asyncio"] == []


def test_garbage_in_place_of_a_handshake(serve: Serve) -> None:
    """Costs its connection only."""
    bridge = serve(limits=GatewayLimits(handshake_seconds=0.5))
    for data in (
        b"\x00" * 1000,
        b"GET / HTTP/1.1\r\n" + b"a" * 100_000,
        b"\x16\x03\x01\x02\x00\x01",
        b"POST / HTTP/1.1\r\n\r\n",
        b"",
    ):
        with socket.create_connection(("127.0.0.1", bridge.port), 10) as sock:
            sock.settimeout(10)
            try:
                sock.sendall(data)
                while sock.recv(1000):
                    pass
            except (ConnectionResetError, BrokenPipeError):
                pass
    with RosbridgeClient(bridge.url) as client:
        assert client.call("/rosapi/get_time")["result"]


def test_wrong_frames_end_their_connection(serve: Serve) -> None:
    """Bytes that are not text, frames without a mask, messages that are too long, odd JSON."""
    bridge = serve(limits=GatewayLimits(message_bytes=1000))
    for frame, code in [
        (b"\x81\x85\0\0\0\0\xff\xfe\xfd\xfc\xfb", 1007),
        (b"\x81\x05hello", 1002),
        (b"\x81\xff" + struct.pack(">Q", 1 << 40) + b"\0\0\0\0", 1009),
        (b"\xf1\x80\0\0\0\0", 1002),
    ]:
        with RosbridgeClient(bridge.url) as client:
            client.socket.sendall(frame)
            with pytest.raises(Exception, match=str(code)):
                client.get()
    with RosbridgeClient(bridge.url) as client:
        for text in ("{", "[]", "null", '{"op": 7}', '{"op": "no_such"}', "[" * 900, b"\xff\xfe"):
            client.send_raw(text)
            assert client.op("status")["level"] == "error"
        assert client.call("/rosapi/get_time")["result"]


@pytest.mark.promise("gives no sign of life for twice `silence_seconds`")
def test_a_client_that_gives_no_sign_of_life_is_given_up(serve: Serve, graph: Graph) -> None:
    """Half-open: its network was lost without a close."""
    bridge = serve(limits=GatewayLimits(silence_seconds=0.3, close_seconds=0.3, linger_seconds=0.05))
    publisher = graph.robot.publisher("/chat", String)
    sock = opened(bridge)
    sock.sendall(framed({"op": "subscribe", "topic": "/chat"}))
    publisher.wait_for_connection(10)
    until(lambda: not bridge.clients)
    until(lambda: publisher.connections == 0)
    sock.close()


@pytest.mark.promise("as every client of a gateway is")
def test_a_client_that_takes_nothing_is_cut_off(serve: Serve, graph: Graph) -> None:
    """Also while so much waits for it that the library's own ping cannot be sent."""
    bridge = serve(limits=GatewayLimits(silence_seconds=0.5, linger_seconds=0.05))
    publisher = graph.robot.publisher("/big", String, queue_size=5)
    sock = opened(bridge)
    sock.sendall(framed({"op": "subscribe", "topic": "/big"}))
    publisher.wait_for_connection(10)
    with RosbridgeClient(bridge.url) as reader:
        end = time.monotonic() + 20
        while len(bridge.clients) > 1:
            assert time.monotonic() < end, "it is still here"
            publisher.publish(data="x" * 1_000_000)
            assert reader.call("/rosapi/get_time")["result"]
        assert len(bridge.clients) == 1
    sock.close()


@pytest.mark.promise("loses the oldest messages of its topics and costs bounded memory")
def test_a_client_that_stops_reading_costs_nobody_else(serve: Serve, graph: Graph) -> None:
    """Its messages are dropped, the oldest first, its memory is bounded, the others get theirs."""
    needs("bridge")  # cbor-raw
    limits = GatewayLimits(topic_bytes=1 << 20, outbox_bytes=2 << 20, linger_seconds=0.05)
    bridge = serve(limits=limits)
    publisher = graph.robot.publisher("/big", String, queue_size=5)
    with RosbridgeClient(bridge.url) as stuck, RosbridgeClient(bridge.url) as reader:
        stuck.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        for client in (stuck, reader):
            client.send(op="subscribe", topic="/big", compression="cbor-raw")
        publisher.wait_for_connection(10)
        until(lambda: sum(len(c.subscriptions) for c in bridge.clients) == 2)
        text = "x" * 300_000
        for i in range(60):
            publisher.publish(data=f"{i} {text}")
            assert len(reader.raw()) > 300_000
        waiting = {client.dropped > 0: client.waiting_bytes for client in bridge.clients}
        assert set(waiting) == {True, False}
        assert waiting[True] <= limits.topic_bytes
        assert waiting[False] == 0


@pytest.mark.promise("on a read-only server it has at most 64 KiB, before authentication 4 KiB")
def test_who_may_write_nothing_says_nothing_long(serve: Serve) -> None:
    """Refused undecoded, by its length alone; before it has authenticated even less."""
    closed = pytest.importorskip(
        "websockets.exceptions", reason='websockets is not installed: pip install ".[bridge]"'
    ).ConnectionClosed
    for options, longest in (({}, 64 << 10), ({"write": ["*"]}, 1 << 20), ({"authenticate": True}, 4 << 10)):
        bridge = serve(**options)
        with RosbridgeClient(bridge.url) as client:
            client.send_raw("x" * longest)
            with suppress(closed):
                assert client.get()["op"] == "status"
        with RosbridgeClient(bridge.url) as client:
            client.send_raw("x" * (longest + 1))
            assert client.closed()[0] == 1009


def test_a_message_that_is_too_long_tells_the_owner_how_to_allow_it(
    serve: Serve, caplog: pytest.LogCaptureFixture
) -> None:
    """The client gets WebSocket's code for it, the log the option."""
    with caplog.at_level("WARNING"), RosbridgeClient(serve(write=["*"]).url) as client:
        client.send_raw("x" * ((1 << 20) + 1))
        assert client.closed()[0] == 1009
        until(lambda: "--message-bytes" in caplog.text)


def test_subprotocols() -> None:
    """The best common subprotocol; a client without one is refused with the list."""
    pytest.importorskip("websockets", reason='websockets is not installed: pip install ".[bridge]"')
    from rosproto.gateway.websocket_server import WebSocketServer

    class Session(Idle):
        def __init__(self, channel: Any) -> None:
            spoken.append(channel.subprotocol)

    spoken: list[str | None] = []
    server = WebSocketServer(Session, HandshakeRules("127.0.0.1", subprotocols=["new", "old"]))
    try:
        for offered in (["old", "new"], ["other", "old"]):
            with RosbridgeClient(server.url, subprotocols=offered):
                until(lambda: len(server.channels) == 1)
            until(lambda: not server.channels)
        assert spoken == ["new", "old"]
        assert " 400 " in asked(server)
        assert " 400 " in asked(server, "Sec-WebSocket-Protocol: other")
        assert server.refused == {"protocol": 2}
    finally:
        server.close()


def test_short_messages_wait_for_no_acknowledgement(serve: Serve) -> None:
    """Without Nagle's algorithm, which asyncio leaves on for a socket that it did not make."""
    bridge = serve()
    with RosbridgeClient(bridge.url) as client:
        until(lambda: len(bridge.clients) == 1)
        ours = client.socket.getsockname()
        ends = [each for each in gc.get_objects() if type(each) is TransportSocket]
        (theirs,) = (each for each in ends if leads_to(each, ours))
        assert theirs.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def leads_to(sock: TransportSocket, address: tuple[str, int]) -> bool:
    with suppress(OSError):
        return bool(sock.getpeername() == address)
    return False


def test_messages_of_every_length_arrive_in_their_order(serve: Serve, graph: Graph) -> None:
    """Written at once, by the client's task, in one frame and in many."""
    bridge = serve()
    publisher = graph.robot.publisher("/texts", String, queue_size=200)
    with RosbridgeClient(bridge.url) as client:
        client.send(op="subscribe", topic="/texts")
        publisher.wait_for_connection(10)
        sizes = [1, 70_000, 2, 20_000, 600_000, 3, 1_500_000, 4, 5, 300_000] * 3
        for i, size in enumerate(sizes):
            publisher.publish(data=f"{i:04}{'x' * size}")
        got = [client.get()["msg"]["data"] for _ in sizes]
        assert [int(text[:4]) for text in got] == list(range(len(sizes)))
        assert [len(text) - 4 for text in got] == sizes


@pytest.mark.promise("one that makes requests and does not read the answers is disconnected")
def test_answers_that_are_not_read_end_the_connection(serve: Serve) -> None:
    """A client that asks, and asks, and does not read."""
    bridge = serve(limits=GatewayLimits(answer_bytes=100_000, close_seconds=0.3))
    sock = opened(bridge)
    question = framed({"op": "no such operation", "id": "x" * 900}) * 50
    deadline = time.monotonic() + 20
    try:
        while time.monotonic() < deadline:
            sock.sendall(question)
            if bridge.stats().accepted and not bridge.clients:
                break
    except OSError:
        pass  # it was cut off while it wrote
    until(lambda: not bridge.clients)
    sock.close()


@pytest.mark.promise("one that makes requests and does not read the answers is disconnected")
def test_pongs_that_are_not_read_end_the_connection(serve: Serve) -> None:
    """They are answers, too, though the library writes them."""
    bridge = serve(limits=GatewayLimits(answer_bytes=100_000, silence_seconds=60))
    with opened(bridge) as sock:
        pings = (b"\x89\xfd\0\0\0\0" + b"x" * 125) * 1000
        until(lambda: len(bridge.clients) == 1)
        end = time.monotonic() + 20
        with suppress(OSError):
            while bridge.clients and time.monotonic() < end:
                sock.sendall(pings)
        until(lambda: not bridge.clients)


def opened(bridge: Any) -> socket.socket:
    """A WebSocket without a reader."""
    sock = half_open(bridge.port)
    sock.sendall(UPGRADE)
    return sock


def framed(message: Any) -> bytes:
    """A text frame of a client."""
    text = json.dumps(message).encode()
    head = bytes([0x81, 0x80 | len(text)]) if len(text) < 126 else b"\x81\xfe" + struct.pack(">H", len(text))
    return head + b"\0\0\0\0" + text


def counts() -> tuple[int, int]:
    """Threads and open files of this process."""
    gc.collect()
    return threading.active_count(), len(os.listdir("/proc/self/fd"))


def unfinished() -> int:
    """Tasks and futures of this process that are not done."""
    found = [each for each in gc.get_objects() if type(each) in (asyncio.Task, Future)]
    return sum(not each.done() for each in found)


@pytest.mark.promise("connect and disconnect leave no thread, file or topic")
@pytest.mark.slow
@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="open files are counted in /proc")
def test_hundreds_that_come_and_go_leave_nothing(serve: Serve, graph: Graph) -> None:
    """Clients that end in order, without a close, in a handshake, a message or a call leave no thread, task, file or topic."""
    bridge = serve(write=["*"], limits=GatewayLimits(linger_seconds=0.05, handshake_seconds=1.0))
    publisher = graph.robot.publisher("/chat", String, latch=True)
    publisher.publish(data="hello")
    empty = service_class("std_srvs/Empty")
    graph.robot.service_server("/slow", empty, lambda _: threading.Event().wait(0.2) and None)

    def one(i: int) -> None:
        if i % 5 == 4:
            sock = socket.create_connection(("127.0.0.1", bridge.port), 10)
            sock.sendall(b"GET / HT")
            sock.close()
            return
        client = RosbridgeClient(bridge.url)
        client.send(op="subscribe", topic="/chat")
        if i % 5 == 1:
            client.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist")
            client.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.1}})
        if i % 5 == 2:
            client.send(op="advertise_service", service="/mine", type="std_srvs/SetBool")
            client.send(op="call_service", service="/slow")
        if i % 5 == 3:
            client.socket.sendall(b"\x81\xfe\x01\x00half")
        if i % 2:
            client.op("publish")
        (client.abort if i % 3 else client.close)()

    def many(count: int) -> None:
        threads = [
            threading.Thread(target=lambda k=k: [one(i) for i in range(k, count, 4)]) for k in range(4)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(120)

    before = unfinished()

    def settled() -> bool:
        state = graph.node.master.get_system_state()
        return (
            not bridge.clients
            and unfinished() <= before
            and bridge.stats().topics == ()
            and publisher.connections == 0
            and "/mine" not in state.services
            and "/cmd_vel" not in state.publishers
        )

    many(20)
    until(settled, 20)
    until(lambda: not [t for t in threading.enumerate() if t.name.startswith("rosproto:leave")], 20)
    many(160)
    until(settled, 20)
    threads, files = counts()
    many(160)
    until(settled, 20)
    until(lambda: counts()[0] <= threads + 2 and counts()[1] <= files + 2, 20)
