"""The thread that watches all subscribers of a node."""

from __future__ import annotations

import selectors
import socket
import threading
from collections.abc import Iterator

import pytest

from rosproto.node.outgoing import link_monitor
from rosproto.node.outgoing.link_monitor import LinkMonitor


class Link:
    """Notes what the monitor calls."""

    def __init__(self) -> None:
        self.sock, self.other = socket.socketpair()
        self.sock.setblocking(False)
        self.readable, self.writable, self.flushed = threading.Event(), threading.Event(), threading.Event()
        self.looked = threading.Event()
        self.monitor: LinkMonitor | None = None

    def on_readable(self) -> None:
        self.sock.recv(100)
        self.readable.set()

    def on_writable(self) -> None:
        self.writable.set()
        if self.monitor is not None:
            self.monitor.want_write(self, False)

    def flush(self) -> None:
        self.flushed.set()

    def look(self, now: float, before: float) -> None:
        self.looked.set()


@pytest.fixture
def monitor() -> Iterator[LinkMonitor]:
    monitor = LinkMonitor("test")
    yield monitor
    monitor.close()


def test_reading_writing_and_batches(monitor: LinkMonitor) -> None:
    """The first link is watched at once; writing only when wanted; a batch is sent soon."""
    link = Link()
    link.monitor = monitor
    monitor.add(link)
    link.other.send(b"x")
    assert link.readable.wait(20)
    assert not link.writable.is_set()
    monitor.want_write(link, True)
    assert link.writable.wait(20)
    for _ in range(3):
        link.flushed.clear()
        monitor.flush_later(link)
        assert link.flushed.wait(20)


def test_removing_closes_the_socket(monitor: LinkMonitor) -> None:
    """The other side sees the end; doing it twice is fine."""
    link = Link()
    monitor.add(link)
    monitor.remove(link)
    monitor.remove(link)
    link.other.settimeout(20)
    assert link.other.recv(1) == b""


def test_closing_the_monitor_closes_what_is_watched() -> None:
    """Also when it never ran, and afterwards a removal still closes."""
    monitor, link, late = LinkMonitor("test"), Link(), Link()
    monitor.add(link)
    monitor.close()
    assert link.sock.fileno() == -1
    monitor.remove(late)
    assert late.sock.fileno() == -1
    LinkMonitor("unused").close()


def test_a_link_that_fails_costs_only_itself(monitor: LinkMonitor, caplog: pytest.LogCaptureFixture) -> None:
    """An exception in one does not end the thread."""
    bad, good = Link(), Link()
    bad.on_readable = lambda: 1 / 0  # type: ignore[assignment,method-assign,return-value]
    for link in (bad, good):
        monitor.add(link)
    bad.other.send(b"x")
    bad.other.settimeout(20)
    with pytest.raises((ConnectionError, AssertionError)):
        assert bad.other.recv(1) != b""
    good.other.send(b"x")
    assert good.readable.wait(20)
    assert "failed unexpectedly" in caplog.text


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> Iterator[LinkMonitor]:
    """As on Windows, where select() takes few sockets: three for each thread here."""
    monkeypatch.setattr(selectors, "DefaultSelector", selectors.SelectSelector)
    monkeypatch.setattr(link_monitor, "MAX_SELECT_SOCKETS", 3)
    monitor = LinkMonitor("narrow")
    yield monitor
    monitor.close()


def threads_of(name: str) -> int:
    return sum(thread.name.startswith(f"rosproto:links {name}") for thread in threading.enumerate())


def test_more_sockets_than_select_takes_are_watched_by_further_threads(narrow: LinkMonitor) -> None:
    """Reading, writing, batches and the end of each, wherever it is watched."""
    links = [Link() for _ in range(10)]
    for link in links:
        link.monitor = narrow
        narrow.add(link)
        link.other.send(b"x")
    assert all(link.readable.wait(20) for link in links)
    assert threads_of("narrow") == 4
    for link in links:
        narrow.want_write(link, True)
        narrow.flush_later(link)
    assert all(link.writable.wait(20) and link.flushed.wait(20) for link in links)
    for link in links:
        narrow.remove(link)
        link.other.settimeout(20)
        assert link.other.recv(1) == b""
    narrow.close()
    assert threads_of("narrow") == 0


def test_closing_ends_what_further_threads_watch(narrow: LinkMonitor) -> None:
    links = [Link() for _ in range(8)]
    for link in links:
        narrow.add(link)
        link.other.send(b"x")
    assert all(link.readable.wait(20) for link in links)
    narrow.close()
    for link in links:
        link.other.settimeout(20)
        assert link.other.recv(1) == b""
    assert threads_of("narrow") == 0


def test_a_place_that_became_free_is_used_again(narrow: LinkMonitor) -> None:
    first, *others = [Link() for _ in range(4)]
    for link in (first, *others[:2]):
        narrow.add(link)
        link.other.send(b"x")
        assert link.readable.wait(20)
    narrow.remove(first)
    first.other.settimeout(20)
    assert first.other.recv(1) == b""
    narrow.add(others[2])
    others[2].other.send(b"x")
    assert others[2].readable.wait(20)
    assert threads_of("narrow") == 1
