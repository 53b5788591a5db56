"""One connected subscriber: no frame stays behind in the batch, however threads meet. The monitor is played by hand."""

from __future__ import annotations

import errno
import socket
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rosproto.errors import ConnectionLost
from rosproto.node.outgoing import subscriber_link
from rosproto.node.outgoing.frames import LargeFrame
from rosproto.node.outgoing.subscriber_link import SubscriberLink
from rosproto.transport import tcp
from rosproto.transport.unsent_bytes import UnsentBytes
from tests.support.marks import needs_rst


class Monitor:
    """Notes whom it is to flush; does it when told."""

    def __init__(self) -> None:
        self.due: list[SubscriberLink] = []

    def add(self, link: SubscriberLink) -> None: ...

    def want_write(self, link: SubscriberLink, wanted: bool) -> None: ...

    def remove(self, link: SubscriberLink) -> None:
        link.sock.close()

    def flush_later(self, link: SubscriberLink) -> None:
        self.due.append(link)

    def tick(self) -> None:
        for _ in range(len(self.due)):
            self.due.pop(0).flush()


class Interrupted(list[bytes]):
    """A batch in which another thread gets its turn right after a frame was put in."""

    meanwhile: Callable[[], object] | None = None

    def append(self, frame: bytes) -> None:
        super().append(frame)
        if self.meanwhile is not None:
            self.meanwhile()


@pytest.fixture
def monitor() -> Monitor:
    return Monitor()


@pytest.fixture
def pair(monitor: Monitor) -> Iterator[tuple[SubscriberLink, socket.socket]]:
    ours, theirs = socket.socketpair()
    theirs.settimeout(0.2)
    fake: Any = monitor
    link = SubscriberLink(
        ours,
        {"callerid": "/s"},
        address="there:1",
        topic="/t",
        queue_size=10,
        monitor=fake,
        on_closed=lambda *_: None,
    )
    yield link, theirs
    link.close()
    theirs.close()


def received(sock: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        data += sock.recv(size - len(data))
    return data


def test_frames_of_a_burst_go_out_together(
    pair: tuple[SubscriberLink, socket.socket], monitor: Monitor
) -> None:
    """Three within the time of a batch: one promise of the monitor, one piece of data."""
    link, theirs = pair
    for number, frame in enumerate((b"one", b"two", b"six")):
        assert not link.send_soon(frame, 1.0 + number * 1e-6)
    assert len(monitor.due) == 1
    monitor.tick()
    assert theirs.recv(100) == b"onetwosix"
    assert link.stats().messages == 3


def test_a_batch_that_is_due_is_sent_by_the_publisher_itself(
    pair: tuple[SubscriberLink, socket.socket], monitor: Monitor
) -> None:
    link, theirs = pair
    link.send_soon(b"one", 1.0)
    assert link.send_soon(b"two", 1.0 + 2 * subscriber_link.BATCH_SECONDS)
    assert received(theirs, 6) == b"onetwo"


def test_the_way_of_a_link_that_lives(monitor: Monitor) -> None:
    """Its header waits, the monitor comes, all is sent; later the socket is full for a while; then the end."""
    ours, theirs = socket.socketpair()
    link = SubscriberLink(
        ours,
        {"callerid": "/s"},
        address="there:1",
        topic="/t",
        queue_size=10,
        monitor=monitor,  # type: ignore[arg-type]
        on_closed=lambda *_: None,
        greeting=b"header",
    )
    seen = [link.stats().state]
    link.start()
    seen.append(link.stats().state)
    while link.stats().state == "connected":
        link.send(bytes(100_000))
    seen.append(link.stats().state)
    theirs.setblocking(False)
    while link.stats().state == "blocked":
        theirs.recv(1 << 20)
        link.on_writable()
    seen.append(link.stats().state)
    link.close()
    link.send(b"late")
    seen.append(link.stats().state)
    theirs.close()
    assert seen == ["opening, blocked", "connected", "blocked", "connected", "closed"]


@pytest.mark.parametrize("turns", [1, 2])
def test_a_frame_that_the_monitor_took_early_leaves_no_other_behind(
    pair: tuple[SubscriberLink, socket.socket], monitor: Monitor, turns: int
) -> None:
    """The monitor flushes between a frame's entering and its being counted. The next frame must go out too.

    A subscriber that answers each message with the next one (both in one node) then waited for ever.
    """
    link, theirs = pair
    link._batch = batch = Interrupted()
    link.send_soon(b"one", 1.0)
    batch.meanwhile = monitor.tick
    link.send_soon(b"two", 1.00001)
    assert received(theirs, 6) == b"onetwo"
    batch.meanwhile = None
    for _ in range(turns):
        monitor.tick()
    link.send_soon(b"six", 1.00002)
    monitor.tick()
    assert received(theirs, 3) == b"six"


def test_sending_at_once_takes_what_waits_along_and_keeps_the_order(
    pair: tuple[SubscriberLink, socket.socket], monitor: Monitor
) -> None:
    link, theirs = pair
    link.send_soon(b"one", 1.0)
    link.send(b"two")
    link.send_soon(b"six", 1.00001)
    monitor.tick()
    assert received(theirs, 9) == b"onetwosix"
    monitor.tick()
    assert link.stats().queued == 0


@pytest.mark.parametrize(
    "end",
    [pytest.param("killed", marks=needs_rst), pytest.param("address changed", marks=needs_rst), "orderly"],
)
def test_what_must_not_come_late_is_thrown_away(end: str, monitor: Monitor) -> None:
    """A reset tells: it goes out when the system drops what it has. An orderly end delivers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        theirs = socket.create_connection(server.getsockname())
        ours = server.accept()[0]
    fake: Any = monitor
    link = SubscriberLink(
        ours, {}, address="there:1", topic="/t", queue_size=10, monitor=fake, on_closed=lambda *_: None
    )
    if end != "address changed":
        link.set_linger(False)
    link.send(b"frame")
    with theirs:
        theirs.settimeout(20)
        assert received(theirs, 5) == b"frame"
        if end == "orderly":
            link.close()
            assert theirs.recv(1) == b""
            return
        if end == "killed":
            ours.close()  # as the system does
        else:
            link.close(deliver=False)
        with pytest.raises(ConnectionResetError):
            theirs.recv(1)


class Interrupting:
    """A socket in whose send() a signal arrives: the handler runs before the code that called send() goes on."""

    def __init__(self, sock: socket.socket, handler: Callable[[], object]) -> None:
        self.sock, self.handler = sock, handler
        self.most = 1 << 20

    def send(self, data: bytes) -> int:
        sent = self.sock.send(data[: self.most])
        handler, self.handler = self.handler, lambda: None
        handler()
        return sent

    def __getattr__(self, name: str) -> Any:
        return getattr(self.sock, name)


@pytest.mark.parametrize("most", [1 << 20, 3], ids=["whole", "in part"])
@pytest.mark.parametrize("how", ["send", "send_soon", "send_large"])
def test_a_signal_handler_may_publish_while_its_thread_is_sending(
    pair: tuple[SubscriberLink, socket.socket], monitor: Monitor, how: str, most: int
) -> None:
    """It neither waits for its own thread nor gets between the halves of a message."""
    link, theirs = pair

    def handler() -> None:
        if how == "send":
            link.send(b"from the handler")
        elif how == "send_soon":
            link.send_soon(b"from the handler", 0.0)
        else:
            link.send_large(LargeFrame([b"from the handler"]))
        link.wait_empty(0.1)

    interrupting: Any = Interrupting(link.sock, handler)
    interrupting.most = most
    link.sock = interrupting
    link.send(b"interrupted ")
    interrupting.most = 1 << 20
    link.on_writable()
    monitor.tick()
    expected = b"interrupted " + (b"\x10\0\0\0" if how == "send_large" else b"") + b"from the handler"
    assert received(theirs, len(expected)) == expected


def test_a_signal_handler_may_close_the_link_that_its_thread_is_sending_on(
    pair: tuple[SubscriberLink, socket.socket],
) -> None:
    link, theirs = pair
    interrupting: Any = Interrupting(link.sock, link.close)
    link.sock = interrupting
    link.send(b"interrupted")
    assert received(theirs, 11) == b"interrupted"
    assert theirs.recv(1) == b""
    link.send(b"nobody")


@pytest.mark.parametrize(
    ("number", "cut"), [(errno.ETIMEDOUT, True), (errno.ECONNABORTED, True), (errno.ECONNRESET, False)]
)
def test_who_was_given_up_by_the_system_is_brought_back(
    monitor: Monitor, monkeypatch: pytest.MonkeyPatch, number: int, cut: bool
) -> None:
    """As after a reset of ours; one that reset the connection itself is not asked back."""
    asked: list[int] = []

    def expect(sock: socket.socket, seconds: int) -> bool:
        asked.append(seconds)
        return True

    monkeypatch.setattr(subscriber_link, "expect_acknowledgement", expect)
    fake: Any = monitor
    with socket.create_server(("127.0.0.1", 0)) as server:
        ours = socket.create_connection(server.getsockname())
        theirs = server.accept()[0]
    ends = ours.getsockname(), ours.getpeername()
    ended: list[object] = []
    link = SubscriberLink(
        ours,
        {"callerid": "/s"},
        address="there:1",
        topic="/t",
        queue_size=10,
        monitor=fake,
        on_closed=lambda link, error: ended.append(error),
    )
    with theirs:
        link._end(OSError(number, "given up"))
    assert asked == [4]
    assert link.reset_ends == (ends if cut else None)
    assert len(ended) == 1
    ours.close()


@pytest.mark.skipif(
    sys.platform == "win32", reason="its socketpair is TCP: the first write after the end succeeds"
)
@pytest.mark.parametrize("kind", ["small", "large", "burst"])
def test_who_publishes_to_a_broken_link_does_not_end_it(kind: str, monitor: Monitor) -> None:
    """An end takes locks, logs, and may start a thread; a stop must wait for none of that. The monitor does it."""
    ours, theirs = socket.socketpair()
    ended: list[object] = []
    fake: Any = monitor
    link = SubscriberLink(
        ours,
        {"callerid": "/s"},
        address="there:1",
        topic="/t",
        queue_size=10,
        monitor=fake,
        on_closed=lambda link, error: ended.append(error),
    )
    link.start()
    theirs.close()
    if kind == "burst":
        link.send_soon(b"xx", 1.0)
        link.send_soon(b"xx", 2.0)
        link.send_soon(b"xx", 3.0)
    elif kind == "large":
        link.send_large(LargeFrame([memoryview(b"a" * 100)]))
    else:
        link.send(b"xx")
    assert not ended
    assert not link.stats().connected
    monitor.tick()
    assert len(ended) == 1
    assert isinstance(ended[0], ConnectionLost)
    link.send(b"xx")  # and nothing more happens
    monitor.tick()
    assert len(ended) == 1


def test_what_was_sent_has_arrived_when_the_system_says_so(
    pair: tuple[SubscriberLink, socket.socket], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And a link that has ended keeps nobody waiting."""
    link, _ = pair
    answer: UnsentBytes | None = UnsentBytes(4, True)
    monkeypatch.setattr(subscriber_link, "unsent_bytes", lambda sock: answer)
    link.send(b"zero")
    assert link.has_arrived() is False
    answer = UnsentBytes(0, False)
    assert link.has_arrived() is True
    answer = None
    assert link.has_arrived() is None
    link.close()
    assert link.has_arrived() is True


@pytest.mark.skipif(sys.platform != "linux", reason="an option of Linux")
def test_while_lost_bytes_are_sent_again_the_system_leaves_the_link_to_us(
    monitor: Monitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It counts from the first loss, and would end a link on poor Wi-Fi that carries data all the time."""
    answer = UnsentBytes(4, True)
    monkeypatch.setattr(subscriber_link, "unsent_bytes", lambda sock: answer)
    fake: Any = monitor
    with (
        socket.create_server(("127.0.0.1", 0)) as server,
        socket.create_connection(server.getsockname()) as ours,
    ):
        tcp.tune(ours)
        link = SubscriberLink(
            ours, {}, address="there:1", topic="/t", queue_size=10, monitor=fake, on_closed=lambda *_: None
        )

        def limit(now: float) -> int:
            link.send(b"data")
            link.look(now, now - 0.5)
            return ours.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT)

        assert limit(100.0) == 30_000
        answer = UnsentBytes(4, True, repairing=True)
        assert limit(100.5) == 30_000
        assert limit(101.5) == 31_000, "thirty seconds from now on, should this program be stopped or killed"
        answer = UnsentBytes(0, False)
        assert limit(102.0) == 30_000
        answer = UnsentBytes(4, True, repairing=True)
        assert limit(102.5) == 30_000, "another loss, another count"
        link.close()
