"""Crowds at the door: connections that say nothing, half of something, or come and go by the thousand."""

from __future__ import annotations

import asyncio
import os
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import PageClient, Served, serving
from woosh_pure import Chassis
from woosh_pure.web import middleware, server
from woosh_pure.web.context import OTHER_CONNECTIONS

HALVES = [
    b"",
    b"\x16\x03\x01",
    b"GET /api/v1/status HT",
    b"GET /api/v1/status HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow:",
    b"POST /api/v1/goals HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 100\r\nContent-Type: application/json\r\n\r\n{",
]
RESET = struct.pack("hh" if sys.platform == "win32" else "ii", 1, 0)
CONNECTS = 3_000
ALL_CONNECTIONS = OTHER_CONNECTIONS + 64


@pytest.fixture
def web(chassis: Chassis) -> Iterator[Served]:
    """A server."""
    with serving(chassis) as served:
        yield served


def slots_of(web: Served) -> Any:
    return web.app.state.context.slots  # type: ignore[attr-defined]


def crowd(port: int, count: int, stack: ExitStack) -> list[socket.socket]:
    """So many connections that say half of something."""
    found = []
    for number in range(count):
        one = stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=10))
        with suppress(OSError):  # another has its place already
            one.sendall(HALVES[number % len(HALVES)])
        found.append(one)
    return found


def is_over(one: socket.socket) -> bool:
    """Whether the server has ended it, by a sentence or without."""
    one.settimeout(10.0)
    try:
        while one.recv(4096):
            pass
    except ConnectionError:
        pass
    return True


@pytest.mark.promise("So a stop gets through")
def test_a_stop_gets_in_however_many_wait_with_half_a_request(web: Served) -> None:
    slots = slots_of(web)
    with ExitStack() as stack:
        crowd(web.port, ALL_CONNECTIONS + 60, stack)
        answer = web.post("stop", timeout=10.0)
        assert answer.status == 200
        assert answer.json["stands_still"] is True
        assert len(slots) <= ALL_CONNECTIONS
        with PageClient(web.port) as page:
            page.of("hello")


@pytest.mark.promise("A connection loses its place after ten seconds")
def test_who_says_half_of_something_is_let_go(web: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    """Headers, bodies and what is not HTTP at all: none of it holds a place for long."""
    slots = slots_of(web)
    monkeypatch.setattr(slots, "_max_silence", 0.5)
    monkeypatch.setattr(middleware, "BODY_SECONDS", 0.5)
    with ExitStack() as stack, PageClient(web.port) as page:
        page.of("hello")
        assert all(map(is_over, crowd(web.port, 2 * len(HALVES), stack)))
        page.forget()
        page.of("pose")
        assert len(slots) == 1, "the page's"


def test_a_body_that_does_not_come_is_a_problem_in_words(
    web: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(middleware, "BODY_SECONDS", 0.3)
    with socket.create_connection(("127.0.0.1", web.port), timeout=10) as slow:
        slow.sendall(HALVES[-1])
        answer = slow.recv(65536).decode()
    assert answer.startswith(("HTTP/1.1 408", "HTTP/1.1 422")), answer
    assert "application/problem+json" in answer


def test_a_stop_needs_no_thread_that_others_have_taken(web: Served, chassis: Chassis) -> None:
    """Forty wait for pictures, each in a thread: the stop of a named robot has its own."""
    context = web.app.state.context  # type: ignore[attr-defined]
    go_on = threading.Event()
    context.robot(None).map.get = lambda: go_on.wait(20.0)
    try:
        with ExitStack() as stack:
            for _ in range(50):
                one = stack.enter_context(socket.create_connection(("127.0.0.1", web.port), timeout=10))
                one.sendall(b"GET /api/v1/map HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
            began = time.monotonic()
            assert web.post("robots/robot/stop").json["stands_still"] is True
            assert time.monotonic() - began < 10.0
    finally:
        go_on.set()


def come_and_leave(port: int, number: int) -> None:
    """One of several ways to come and to leave again."""
    with socket.create_connection(("127.0.0.1", port), timeout=20) as one:
        way = number % 8
        with suppress(OSError):
            if way < len(HALVES):
                one.sendall(HALVES[way])
            elif way == 5:
                one.sendall(b"GET /api/v1/status HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n")
                one.recv(100)
            elif way == 6:
                one.sendall(
                    b"GET /api/v1/live HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
                )
            if number % 2:
                one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)


def open_files() -> int:
    """Of this process; 0 where nobody tells."""
    folder = Path("/proc/self/fd")
    return len(list(folder.iterdir())) if folder.is_dir() else 0


def resident() -> int:
    """Bytes in memory; 0 where nobody tells."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, AttributeError, ValueError):
        return 0


@pytest.mark.slow
def test_thousands_of_connects_leave_nothing(web: Served, until: Callable[..., None]) -> None:
    """No thread, no task, no file, no memory; and the page of somebody who looks all the time goes on."""
    context, slots = web.app.state.context, slots_of(web)  # type: ignore[attr-defined]

    def tasks() -> int:
        loop = web.loop()  # type: ignore[attr-defined]
        return len(asyncio.all_tasks(loop))

    with PageClient(web.port) as page:
        page.of("hello")
        for number in range(400):  # what is made once is made
            come_and_leave(web.port, number)
        until(lambda: len(slots) == 1 and context.viewers == 1, what="an empty hall")
        time.sleep(0.5)
        before = threading.active_count(), tasks(), open_files(), resident()
        for number in range(CONNECTS):
            come_and_leave(web.port, number)
        until(lambda: len(slots) == 1 and context.viewers == 1, 30.0, "an empty hall")
        # The pool of the server's library keeps what a busy computer made it start, at most 40.
        until(lambda: threading.active_count() <= before[0] + 40, 30.0, "no thread more")
        until(lambda: tasks() <= before[1] + 2, 30.0, "no task more")
        until(lambda: open_files() <= before[2] + 4, 30.0, "no file more")
        assert resident() - before[3] < 9e6
        assert len(context.clients._known) <= 256
        page.forget()
        page.of("pose")


@pytest.mark.promise("64 viewers, 32 event streams")
def test_streams_that_are_asked_for_at_once_are_counted_too(web: Served, until: Callable[..., None]) -> None:
    request = b"GET /api/v1/feeds/battery/stream HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    with ExitStack() as stack:
        sockets = [
            stack.enter_context(socket.create_connection(("127.0.0.1", web.port), timeout=20))
            for _ in range(60)
        ]
        for one in sockets:
            one.sendall(request)
        statuses = [int(one.recv(12).split()[1]) for one in sockets]
    assert (statuses.count(200), statuses.count(429)) == (32, 28)
    until(lambda: web.app.state.context.streams == 0, 20.0, "the end of the streams")  # type: ignore[attr-defined]


# -- frames that a browser would not send --------------------------------------------------------------------

FIRST, EMPTY, LAST = b"\x01\x82\0\0\0\0{}", b"\x00\x80\0\0\0\0", b"\x80\x80\0\0\0\0"
"""A text frame that is not the last of its message, a continuation without content, and the last one."""


def live_socket(web: Served) -> socket.socket:
    """The live connection as a bare socket, after a handshake with the token."""
    one = socket.create_connection(("127.0.0.1", web.port), timeout=10)
    one.sendall(
        b"GET /api/v1/live HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
        b"Authorization: Bearer " + (web.token or "").encode() + b"\r\n\r\n"
    )
    assert one.recv(12) == b"HTTP/1.1 101"
    return one


def read_in_thread(one: socket.socket) -> bytearray:
    """What the server sends, read so that it can go on writing."""
    heard = bytearray()

    def read() -> None:
        with suppress(OSError):
            while data := one.recv(65536):
                heard.extend(data)

    threading.Thread(target=read, daemon=True).start()
    return heard


def ends_within(one: socket.socket, seconds: float) -> bool:
    """Whether the server ends the connection in that time."""
    until = time.monotonic() + seconds
    try:
        while (left := until - time.monotonic()) > 0:
            one.settimeout(left)
            if not one.recv(65536):
                return True
    except ConnectionError:
        return True
    except TimeoutError:
        pass
    return False


@pytest.mark.promise("4096 letters in at most 64 frames")
def test_a_message_has_64_frames_at_most(
    chassis: Chassis, until: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Empty continuation frames take memory that no limit of bytes counts."""
    monkeypatch.setattr(server, "PONG_SECONDS", 60.0)  # these sockets answer no ping
    with serving(chassis, token="a-secret-of-the-test") as web:
        with live_socket(web) as one:
            heard = read_in_thread(one)
            one.sendall(FIRST + EMPTY * 62 + LAST)
            until(
                lambda: b"is not a message of this connection" in heard, what="an answer to the whole message"
            )
        with live_socket(web) as one:
            one.sendall(FIRST + EMPTY * 64)
            assert ends_within(one, 8.0)
        before = resident()
        with live_socket(web) as one:
            with suppress(ConnectionError):
                one.sendall(FIRST + EMPTY * 400_000)
            assert ends_within(one, 8.0)
            assert resident() - before < 9e6
        with PageClient(web.port, additional_headers={"Authorization": f"Bearer {web.token}"}) as page:
            page.of("hello")
