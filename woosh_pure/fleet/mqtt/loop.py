"""One thread for the lines of all vehicles of a process to their brokers.

paho-mqtt has a thread for each connection, which wakes up once a second and waits by select(), which takes no
file beyond the 1024th. Here its loop for others' event loops is used: one selector waits for all sockets,
each line is looked after when something came, when it has something to send, or when the time of a ping is
here, and otherwise not at all. The connections themselves are opened in threads that end with it, because
names, TCP and TLS take their time; `Turns` says which.

Whoever is called here belongs to the loop's thread, but for `join`, `leave`, `call` and `wake`. Where the
system has only select(), which takes a few hundred sockets (Windows), further lines go to a further loop.
"""

from __future__ import annotations

import heapq
import itertools
import math
import os
import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Hashable
from functools import partial
from typing import Any, Protocol

from rosproto.logs import get_logger
from woosh_pure.fleet.mqtt.attempts import Turns

__all__ = ["Loop", "Wire", "shared_loop"]

_log = get_logger("woosh_pure.fleet.mqtt.loop")
_MOST_IN_SELECT = 500  # Windows' select() takes 512 sockets
_SHORTEST_STEP = 0.01  # s between two looks at the time of one line
_LONGEST_SLEEP = 60.0  # only so that no wait is without an end


class Wire(Protocol):
    """What the loop asks of a line."""

    @property
    def place(self) -> Hashable:
        """Its broker: lines of one place take turns."""

    @property
    def due(self) -> float:
        """When `on_time` is to be called, by the monotonic clock; inf while it is not."""

    def connect(self) -> Any:
        """Open a connection; in a thread of its own, may take seconds. Raises what went wrong."""

    def made(self, connection: Any) -> None:
        """The connection is open."""

    def failed(self, error: Exception) -> None:
        """It could not be opened."""

    def serve(self, events: int) -> None:
        """Its socket can be read or written."""

    def on_time(self) -> None:
        """`due` is here."""

    def broken(self) -> None:
        """It raised an exception: end the connection."""


class Loop:
    """The thread; it begins with the first line and ends with the last."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        self._wake_in, self._wake_out = socket.socketpair()
        for end in (self._wake_in, self._wake_out):
            end.setblocking(False)
        self._selector.register(self._wake_in, selectors.EVENT_READ, None)
        self.process = os.getpid()
        self.ended = False
        self._lock = threading.Lock()
        self._joined = 0
        self._sleeping = False
        self._requests: deque[Callable[[], object]] = deque()
        self._times: list[tuple[float, int, Wire]] = []
        self._timed: set[Wire] = set()
        self._number = itertools.count()
        self._turns: dict[Hashable, Turns[Wire]] = {}
        self._lines: set[Wire] = set()
        self._thread: threading.Thread | None = None

    # -- from any thread -------------------------------------------------------------------------------------

    def join(self, line: Wire) -> bool:
        """Connect a line, and look after it until `leave`; False when this loop has ended or is full."""
        with self._lock:
            full = isinstance(self._selector, selectors.SelectSelector) and self._joined >= _MOST_IN_SELECT
            if self.ended or full:
                return False
            self._joined += 1
            self._requests.append(lambda: self._add(line))
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="woosh:mqtt", daemon=True)
                self._thread.start()
        self._wake()
        return True

    def leave(self, line: Wire) -> None:
        """Look after it no more; its socket is its own to close."""
        self.call(lambda: self._remove(line))

    def call(self, request: Callable[[], object]) -> None:
        """Have something done in the loop's thread."""
        self._requests.append(request)
        self._wake()

    @property
    def inside(self) -> bool:
        """Whether the caller is the loop's thread."""
        return threading.current_thread() is self._thread

    def _wake(self) -> None:
        # The loop notes that it sleeps before it looks for requests the last time: none is overlooked.
        if self._sleeping:
            try:
                self._wake_out.send(b"\0")
            except OSError:
                pass  # full: it is being woken already; closed: it has ended

    # -- for the lines, in the loop's thread -----------------------------------------------------------------

    def watch(self, line: Wire, sock: socket.socket, events: int) -> None:
        """Wait for a socket of a line, for other events than before."""
        key = self._selector.get_map().get(sock)
        if key is None:
            self._selector.register(sock, events, line)
        elif key.events != events:
            self._selector.modify(sock, events, line)

    def unwatch(self, sock: socket.socket) -> None:
        """Wait for it no more; before it is closed."""
        try:
            self._selector.unregister(sock)
        except (KeyError, ValueError):
            pass  # it was never waited for

    def turns(self, line: Wire) -> Turns[Wire]:
        """The tries to connect with the line's broker."""
        return self._turns.setdefault(line.place, Turns())

    # -- the thread ------------------------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            while self._round():
                pass
        except Exception:
            _log.exception("! the loop of the brokers' lines has failed")
            self.ended = True
        finally:
            self._selector.close()
            self._wake_in.close()
            self._wake_out.close()

    def _round(self) -> bool:
        while self._requests:
            request = self._requests.popleft()
            try:
                request()
            except Exception:
                _log.exception("! a request to the loop of the brokers' lines has failed")
        with self._lock:
            if not self._joined:
                self.ended = True
                return False
        now = time.monotonic()
        self._begin_tries(now)
        self._on_time(now)
        self._sleeping = True
        wait = 0.0 if self._requests else max(0.0, self._next(now) - now)
        ready = self._selector.select(wait)
        self._sleeping = False
        for key, events in ready:
            if key.data is None:
                self._drain()
            else:
                self._guarded(key.data, partial(key.data.serve, events))
        return True

    def _guarded(self, line: Wire, work: Callable[[], object]) -> None:
        try:
            work()
        except Exception:
            _log.exception("! a line to a broker has failed; it is made anew: %r", line)
            line.broken()

    def _drain(self) -> None:
        try:
            self._wake_in.recv(4096)
        except OSError:
            pass  # drained already

    def _next(self, now: float) -> float:
        times = [due for turns in self._turns.values() if (due := turns.due()) is not None]
        if self._times:
            times.append(self._times[0][0])
        return min(times, default=now + _LONGEST_SLEEP)

    def _on_time(self, now: float) -> None:
        while self._times and self._times[0][0] <= now:
            _, _, line = heapq.heappop(self._times)
            self._timed.discard(line)
            if line in self._lines:
                if line.due <= now:
                    self._guarded(line, line.on_time)
                self._note(line, now)

    def _note(self, line: Wire, now: float) -> None:
        """Each line that has a time has one entry. It may be earlier than the time has become meanwhile."""
        if line.due < math.inf and line not in self._timed:
            self._timed.add(line)
            heapq.heappush(self._times, (max(line.due, now + _SHORTEST_STEP), next(self._number), line))

    def _add(self, line: Wire) -> None:
        self._lines.add(line)
        self.turns(line).ask(line)

    def _remove(self, line: Wire) -> None:
        if line in self._lines:
            self._lines.discard(line)
            self.turns(line).forget(line)
            with self._lock:
                self._joined -= 1

    def _begin_tries(self, now: float) -> None:
        for turns in self._turns.values():
            for line in turns.begin(now):
                threading.Thread(
                    target=self._connect, args=(line,), name="woosh:mqtt-connect", daemon=True
                ).start()

    def _connect(self, line: Wire) -> None:
        """In a thread of its own."""
        try:
            made = line.connect()
        except Exception as error:
            failure = error
            self.call(lambda: line.failed(failure))
        else:
            self.call(lambda: self._connected(line, made))

    def _connected(self, line: Wire, made: Any) -> None:
        self._guarded(line, lambda: line.made(made))
        if line in self._lines:
            self._note(line, time.monotonic())


_loops: list[Loop] = []
_lock = threading.Lock()


def shared_loop(line: Wire) -> Loop:
    """Have one of this process's loops look after a line; there is one for all, made with the first."""
    with _lock:
        # A process that was forked has the objects of its parent, and none of their threads.
        _loops[:] = [loop for loop in _loops if not loop.ended and loop.process == os.getpid()]
        for loop in _loops:
            if loop.join(line):
                return loop
        loop = Loop()
        loop.join(line)
        _loops.append(loop)
        return loop
