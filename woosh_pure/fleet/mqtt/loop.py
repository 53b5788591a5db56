"""One thread for the connections of all vehicles of a process to their brokers.

paho-mqtt starts a thread for each connection, which wakes up once a second and waits in select(), which takes
no file beyond the 1024th. Here its interface for external event loops is used instead: one selector waits for
all sockets, and a connection is looked after when something has arrived, when it has something to send, or
when it is time for a ping; otherwise it costs nothing. Connections are opened in short-lived threads, because
resolving names, TCP and TLS take their time; `ConnectionAttempts` says which may try.

Everything here runs in the loop's thread, except `join`, `leave` and `call`. Where the system only has
select(), which takes a few hundred sockets (Windows), further connections go to a further loop.
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
from woosh_pure.fleet.mqtt.attempts import ConnectionAttempts

__all__ = ["Connection", "Loop", "shared_loop"]

_log = get_logger("woosh_pure.fleet.mqtt.loop")
_MOST_IN_SELECT = 500  # Windows' select() takes 512 sockets
_SHORTEST_STEP = 0.01  # s between two looks at the time of one connection
_LONGEST_SLEEP = 60.0  # only so that no wait is without an end


class Connection(Protocol):
    """What the loop asks of a connection."""

    @property
    def broker_address(self) -> Hashable:
        """Its broker: connections to one broker take turns."""

    @property
    def due(self) -> float:
        """When `on_due` is to be called, by the monotonic clock; inf while it is not."""

    def connect(self) -> Any:
        """Open a connection; in a thread of its own, may take seconds. Raises what went wrong."""

    def opened(self, connection: Any) -> None:
        """The connection is open."""

    def failed(self, error: Exception) -> None:
        """It could not be opened."""

    def serve(self, events: int) -> None:
        """Its socket can be read or written."""

    def on_due(self) -> None:
        """`due` is here."""

    def broken(self) -> None:
        """It raised an exception: end the connection."""


class Loop:
    """The thread; it starts with the first connection and ends with the last."""

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
        self._times: list[tuple[float, int, Connection]] = []
        self._timed: set[Connection] = set()
        self._number = itertools.count()
        self._attempts: dict[Hashable, ConnectionAttempts[Connection]] = {}
        self._connections: set[Connection] = set()
        self._thread: threading.Thread | None = None

    # -- from any thread -------------------------------------------------------------------------------------

    def join(self, connection: Connection) -> bool:
        """Open a connection, and look after it until `leave`; False when this loop has ended or is full."""
        with self._lock:
            full = isinstance(self._selector, selectors.SelectSelector) and self._joined >= _MOST_IN_SELECT
            if self.ended or full:
                return False
            self._joined += 1
            self._requests.append(lambda: self._add(connection))
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="woosh:mqtt", daemon=True)
                self._thread.start()
        self._wake()
        return True

    def leave(self, connection: Connection) -> None:
        """Look after it no more; its socket is its own to close."""
        self.call(lambda: self._remove(connection))

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

    # -- for the connections, in the loop's thread -----------------------------------------------------------

    def watch(self, connection: Connection, sock: socket.socket, events: int) -> None:
        """Wait for a socket of a connection, for other events than before."""
        key = self._selector.get_map().get(sock)
        if key is None:
            self._selector.register(sock, events, connection)
        elif key.events != events:
            self._selector.modify(sock, events, connection)

    def unwatch(self, sock: socket.socket) -> None:
        """Wait for it no more; before it is closed."""
        try:
            self._selector.unregister(sock)
        except (KeyError, ValueError):
            pass  # it was never waited for

    def attempts(self, connection: Connection) -> ConnectionAttempts[Connection]:
        """The attempts to connect with a connection's broker."""
        return self._attempts.setdefault(connection.broker_address, ConnectionAttempts())

    # -- the thread ------------------------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            while self._round():
                pass
        except Exception:
            _log.exception("! the loop of the MQTT connections has failed")
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
                _log.exception("! a request to the loop of the MQTT connections has failed")
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

    def _guarded(self, connection: Connection, work: Callable[[], object]) -> None:
        try:
            work()
        except Exception:
            _log.exception("! a connection to a broker has failed; it is made anew: %r", connection)
            connection.broken()

    def _drain(self) -> None:
        try:
            self._wake_in.recv(4096)
        except OSError:
            pass  # drained already

    def _next(self, now: float) -> float:
        times = [due for attempts in self._attempts.values() if (due := attempts.due()) is not None]
        if self._times:
            times.append(self._times[0][0])
        return min(times, default=now + _LONGEST_SLEEP)

    def _on_time(self, now: float) -> None:
        while self._times and self._times[0][0] <= now:
            _, _, connection = heapq.heappop(self._times)
            self._timed.discard(connection)
            if connection in self._connections:
                if connection.due <= now:
                    self._guarded(connection, connection.on_due)
                self._note(connection, now)

    def _note(self, connection: Connection, now: float) -> None:
        """Each connection with a due time has one entry, which may be earlier than that time is by now."""
        if connection.due < math.inf and connection not in self._timed:
            self._timed.add(connection)
            heapq.heappush(
                self._times, (max(connection.due, now + _SHORTEST_STEP), next(self._number), connection)
            )

    def _add(self, connection: Connection) -> None:
        self._connections.add(connection)
        self.attempts(connection).request(connection)

    def _remove(self, connection: Connection) -> None:
        if connection in self._connections:
            self._connections.discard(connection)
            self.attempts(connection).forget(connection)
            with self._lock:
                self._joined -= 1

    def _begin_tries(self, now: float) -> None:
        for attempts in self._attempts.values():
            for connection in attempts.begin(now):
                threading.Thread(
                    target=self._connect, args=(connection,), name="woosh:mqtt-connect", daemon=True
                ).start()

    def _connect(self, connection: Connection) -> None:
        """In a thread of its own."""
        try:
            made = connection.connect()
        except Exception as error:
            failure = error
            self.call(lambda: connection.failed(failure))
        else:
            self.call(lambda: self._connected(connection, made))

    def _connected(self, connection: Connection, made: Any) -> None:
        self._guarded(connection, lambda: connection.opened(made))
        if connection in self._connections:
            self._note(connection, time.monotonic())


_loops: list[Loop] = []
_lock = threading.Lock()


def shared_loop(connection: Connection) -> Loop:
    """Have one of this process's loops look after a connection; usually there is one, made with the first."""
    with _lock:
        # A process that was forked has the objects of its parent, and none of their threads.
        _loops[:] = [loop for loop in _loops if not loop.ended and loop.process == os.getpid()]
        for loop in _loops:
            if loop.join(connection):
                return loop
        loop = Loop()
        loop.join(connection)
        _loops.append(loop)
        return loop
