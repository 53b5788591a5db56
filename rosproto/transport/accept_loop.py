"""One thread that waits for connections to all servers of this process.

A thread, a selector and a pair of sockets for each server took five files and two threads of a node, and a
simulated robot has twenty nodes. What is called here must not wait: a server gives each connection a thread.
"""

from __future__ import annotations

import selectors
import socket
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress

from rosproto.logs import get_logger
from rosproto.transport.deadline import Deadline, wait_event
from rosproto.transport.forking import close_in_forked_children, on_fork
from rosproto.transport.tcp import open_selector, wake_pair

_log = get_logger("rosproto.transport")
_MAX_SELECT_SOCKETS = 500  # Windows' select() takes 512
_DOING = "wait for connections"


class AcceptLoop:
    """The thread and its selector; it ends when the last listener is removed."""

    def __init__(self) -> None:
        self._selector = open_selector(_DOING)
        try:
            self._wake_in, self._wake_out = wake_pair(_DOING)
        except BaseException:
            self._selector.close()
            raise
        for sock in (self._wake_in, self._wake_out):
            sock.setblocking(False)
            close_in_forked_children(sock)
        self._selector.register(self._wake_in, selectors.EVENT_READ)
        self._requests: deque[Callable[[], object]] = deque()
        self.count = 0  # of listeners, guarded by `_lock`
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="rosproto:accept", daemon=True)

    @property
    def is_full(self) -> bool:
        """Whether it takes no more listeners."""
        return isinstance(self._selector, selectors.SelectSelector) and self.count >= _MAX_SELECT_SOCKETS

    def start(self) -> None:
        """Start the thread."""
        try:
            self._thread.start()
        except BaseException:
            self._close()
            raise

    def request(self, request: Callable[[], object]) -> None:
        """Have the thread call this; only it uses the selector."""
        self._requests.append(request)
        with suppress(OSError):  # full: it is being woken
            self._wake_out.send(b"\0")

    def watch(self, listener: socket.socket, accept: Callable[[], object]) -> None:
        """Call `accept` while connections wait; called in the thread."""
        self._selector.register(listener, selectors.EVENT_READ, accept)

    def forget(self, listener: socket.socket, done: threading.Event, last: bool) -> None:
        """Wait for no more connections, and close the listener; called in the thread."""
        with suppress(KeyError, ValueError):
            self._selector.unregister(listener)
        listener.close()
        self._ended = last
        done.set()

    def wait(self, done: threading.Event, timeout: float | None) -> None:
        """Wait for the end of `stop_accepting`, and of the thread if it ends, unless called in it."""
        if threading.current_thread() is not self._thread:
            deadline = Deadline(timeout)
            if wait_event(done, timeout) and self._ended:
                self._thread.join(deadline.remaining())

    def _run(self) -> None:
        while not self._ended:
            for key, _ in self._selector.select():
                if key.data is not None:
                    try:
                        key.data()
                    except Exception:
                        _log.exception("! accepting failed: %r", key.data)
                else:
                    with suppress(OSError):
                        self._wake_in.recv(4096)
            while self._requests:
                self._requests.popleft()()
        self._close()

    def _close(self) -> None:
        self._selector.close()
        self._wake_in.close()
        self._wake_out.close()


_lock = threading.Lock()
_loops: list[AcceptLoop] = []


def accept_from(listener: socket.socket, accept: Callable[[], object]) -> AcceptLoop:
    """Call `accept` in the shared thread whenever a connection waits.

    Raises:
        ConnectionLost: No file is left to open.
        RuntimeError: No thread can be started.
    """
    with _lock:
        on_fork(_forget_loops)
        loop = next((loop for loop in _loops if not loop.is_full), None)
        if loop is None:
            loop = AcceptLoop()
            loop.start()
            _loops.append(loop)
        loop.count += 1
        loop.request(lambda: loop.watch(listener, accept))
        return loop


def stop_accepting(loop: AcceptLoop, listener: socket.socket) -> threading.Event:
    """Close the listener in the shared thread; the event is set when that has happened."""
    done = threading.Event()
    with _lock:
        loop.count -= 1
        last = not loop.count
        if last and loop in _loops:
            _loops.remove(loop)
        loop.request(lambda: loop.forget(listener, done, last))
    return done


def _forget_loops() -> None:
    """A fork has none of the threads."""
    global _lock
    _lock = threading.Lock()
    _loops.clear()
