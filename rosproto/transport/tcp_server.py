"""Accept TCP connections and give each a thread, within limits.

One thread of the process accepts for all servers (`accept_loop.py`). It never reads, so a silent peer does
not block others (in rospy it does).

A connection is in one of three states. *Pending*: accepted, its handshake not finished. *Established*: the
handler called `established`. *Idle*: the handler called `idle`; it is kept open for a next request. When too
many are pending, the oldest pending one of the address that has the most is dropped (`ConnectionSlots`): a
normal handshake takes milliseconds, so that one stalls. When the limit of connections is reached, the longest
idle one is dropped; if none is idle, the new one is refused. When the process has few files left
(`max_connections`), or none, a pending one is dropped, or else the longest idle one.
"""

from __future__ import annotations

import itertools
import os
import socket
import threading
from collections import OrderedDict
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial

from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.accept_loop import accept_from, stop_accepting
from rosproto.transport.connection_slots import ConnectionSlots, Key
from rosproto.transport.deadline import SYSTEM, Clock, Deadline
from rosproto.transport.forking import close_in_forked_children, is_forked_child
from rosproto.transport.os_errors import (
    connection_is_over,
    interpreter_shuts_down,
    is_out_of_files,
    max_connections,
)
from rosproto.transport.tcp import bind_beside, interrupt, listen, tune
from rosproto.transport.uri import format_address

log = get_logger("rosproto.transport")

Allow = Callable[[str], bool] | Collection[str] | None
OnConnection = Callable[[socket.socket, tuple[str, int]], object]
_ACCEPT_PAUSE = 0.02  # after accept() failed (out of file descriptors): do not spin


@dataclass(slots=True)
class ServerStats:
    """Counters since the start."""

    accepted: int = 0
    not_allowed: int = 0
    refused_full: int = 0
    dropped_pending: int = 0
    dropped_idle: int = 0
    failed: int = 0


class TcpServer:
    """Listens on exactly one address and calls `on_connection(sock, (host, port))` in a thread per peer.

    The socket is blocking and tuned. It is closed when `on_connection` returns, so a handler runs as long as
    the connection lives (as the reader of its link), or calls `hand_over` to let the connection outlive its
    thread. An error that it raises ends that connection only. After its handshake the handler calls
    `established(sock)`; until then the connection is pending.

    Args:
        host: The only address to listen on.
        port: Port, 0 for a free one.
        on_connection: The handler.
        limits: `connections` and `pending_handshakes` are used.
        allow: Who may connect: addresses, or a function of the address; None for everybody.
        name: For thread names and log lines.
        clock: Measures time-outs.

    Attributes:
        host: As given.
        port: The actual port.
        stats: Counters.
    """

    def __init__(
        self,
        host: str,
        port: int,
        on_connection: OnConnection,
        *,
        limits: Limits | None = None,
        allow: Allow = None,
        name: str = "tcp",
        clock: Clock = SYSTEM,
    ) -> None:
        self.host = host
        self.stats = ServerStats()
        self._on_connection = on_connection
        self._limits = limits or Limits()
        self._allow = allow
        self._name = name
        self._clock = clock
        self._lock = threading.Lock()  # guards the tables below; never held during I/O that can block
        self._threads: dict[socket.socket, threading.Thread] = {}
        self._pending = ConnectionSlots(self._limits.pending_handshakes)
        self._keys: dict[socket.socket, Key] = {}  # in `_pending`: the address, and a number
        self._numbers = itertools.count()
        self._idle: OrderedDict[socket.socket, None] = OrderedDict()
        self._handed_over: set[socket.socket] = set()
        self._accept_failing = False  # so that a series of failures is logged once
        self._closing = threading.Event()
        self._process = os.getpid()
        self._listener = listen(host, port)
        self.port = int(self._listener.getsockname()[1])
        close_in_forked_children(self._listener)
        self._listener.setblocking(False)
        try:
            self._loop = accept_from(self._listener, self._accept_one)
        except BaseException:
            self._listener.close()
            raise
        self._stopped: threading.Event | None = None  # set when the listener is closed

    def bind_beside(self, sock: socket.socket, address: tuple[str, int]) -> None:
        """Bind a socket that will connect from the address this server listens on; see `tcp.bind_beside`.

        Raises:
            OSError: The system does not allow it.
        """
        with self._lock:
            bind_beside(sock, self._listener, address)

    def __enter__(self) -> TcpServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self.closed else f"{self.connections} connections"
        return f"<TcpServer {self._name} {format_address(self.host, self.port)} {state}>"

    @property
    def closed(self) -> bool:
        """Whether `close()` was called."""
        return self._closing.is_set()

    @property
    def connections(self) -> int:
        """Number of open connections in any state."""
        with self._lock:
            return self._count()

    @property
    def pending(self) -> int:
        """Number of connections whose handshake is not finished."""
        with self._lock:
            return len(self._pending)

    def established(self, sock: socket.socket) -> None:
        """Mark the handshake as finished (or an idle connection as busy again)."""
        with self._lock:
            self._is_not_pending(sock)
            self._idle.pop(sock, None)

    def idle(self, sock: socket.socket) -> None:
        """Mark the connection as idle: it may be dropped to make room."""
        with self._lock:
            self._is_not_pending(sock)
            if sock in self._threads:
                self._idle[sock] = None

    def hand_over(self, sock: socket.socket) -> None:
        """Let the connection outlive its thread: the new owner of the socket closes it, this server does not.

        It counts against `limits.connections` until `released` is called for it.
        """
        with self._lock:
            self._is_not_pending(sock)
            self._idle.pop(sock, None)
            if sock in self._threads:
                self._handed_over.add(sock)

    def released(self, sock: socket.socket) -> None:
        """Report that a connection that was handed over is closed."""
        with self._lock:
            self._handed_over.discard(sock)

    def close(self, timeout: float = 5.0) -> None:
        """Stop listening, drop all connections, wait for their threads up to `timeout` seconds."""
        if is_forked_child(self._process):
            return  # a forked child has no thread of it, and must not end the connections
        deadline = Deadline(timeout, self._clock)
        with self._lock:
            if self._stopped is None:
                self._closing.set()
                self._stopped = stop_accepting(self._loop, self._listener)
            threads = dict(self._threads)
            sockets = self._threads.keys() - self._handed_over
        for sock in sockets:
            interrupt(sock)
        self._loop.wait(self._stopped, deadline.remaining())
        for thread in threads.values():
            if thread is not threading.current_thread():
                thread.join(deadline.remaining())

    def _accept_one(self) -> None:
        if self._closing.is_set():
            return
        try:
            sock, address = self._listener.accept()
        except (BlockingIOError, InterruptedError):
            return
        except OSError as error:
            if connection_is_over(error):
                return  # already closed
            if not self._accept_failing:
                log.warning("! %s: accept failed: %s; trying again", self._name, error)
            self._accept_failing = True
            self.stats.failed += 1
            if is_out_of_files(error):
                self._give_up_one()
            self._closing.wait(_ACCEPT_PAUSE)
            return
        self._accept_failing = False
        self.stats.accepted += 1
        if not address:  # macOS: the peer has reset the connection meanwhile and has no address any more
            sock.close()
            return
        peer = (str(address[0]).removeprefix("::ffff:"), int(address[1]))
        try:
            if not self._admit(sock, peer):
                sock.close()
        except Exception as error:
            sock.close()
            self.stats.failed += 1
            if not interpreter_shuts_down(error):
                log.exception(
                    "! %s: connection from %s could not be handled", self._name, format_address(*peer)
                )

    def _admit(self, sock: socket.socket, peer: tuple[str, int]) -> bool:
        if not self.allows(peer[0]):
            self.stats.not_allowed += 1
            log.warning("! %s: %s is not allowed to connect (allow=)", self._name, peer[0])
            return False
        close_in_forked_children(sock)
        sock.setblocking(True)
        tune(sock)
        thread = threading.Thread(
            target=self._serve,
            args=(sock, peer),
            name=f"rosproto:{self._name} {format_address(*peer)}",
            daemon=True,
        )
        with self._lock:
            if self._closing.is_set() or not self._make_room(sock):
                return False
            # started with the lock held, so that close() never finds a thread that cannot be joined yet;
            # raises RuntimeError if the system has no more threads
            thread.start()
            self._threads[sock] = thread
            key = self._keys[sock] = (peer[0], next(self._numbers))
            self._pending.admit(key, partial(self._end_pending, sock), self._clock.monotonic())
        return True

    def allows(self, host: str) -> bool:
        """Whether that address may connect."""
        if self._allow is None:
            return True
        return self._allow(host) if callable(self._allow) else host in self._allow

    def _make_room(self, sock: socket.socket) -> bool:
        assert self._lock.locked()
        open_now = self._threads.keys() | self._handed_over
        if len(open_now) >= max_connections(sock.fileno(), [each.fileno() for each in open_now]):
            _ = self._pending.drop_one() or self._drop_idle()
        if self._count() < self._limits.connections:
            return True
        if self._drop_idle():
            return True
        self.stats.refused_full += 1
        log.warning("! %s: connection refused: %d connections are open, the limit", self._name, self._count())
        return False

    def _give_up_one(self) -> None:
        """Drop a connection because the system ran out of files before our own limits were reached."""
        with self._lock:
            _ = self._pending.drop_one() or self._drop_idle()

    def _end_pending(self, sock: socket.socket) -> None:
        """End a connection that has lost its slot: its thread wakes up, closes it and ends."""
        interrupt(sock)
        self.stats.dropped_pending += 1

    def _is_not_pending(self, sock: socket.socket) -> None:
        key = self._keys.pop(sock, None)
        if key is not None:
            self._pending.release(key)

    def _drop_idle(self) -> bool:
        """Drop the longest idle connection, if there is one."""
        if not self._idle:
            return False
        interrupt(self._idle.popitem(last=False)[0])
        self.stats.dropped_idle += 1
        return True

    def _count(self) -> int:
        assert self._lock.locked()
        return len(self._threads.keys() | self._handed_over)

    def _serve(self, sock: socket.socket, peer: tuple[str, int]) -> None:
        try:
            with self._lock:
                pass  # _admit has added us to the tables
            self._on_connection(sock, peer)
        except RosError as error:
            log.debug("! %s: %s: %s", self._name, format_address(*peer), error)
        except Exception as error:
            if isinstance(error, OSError) and connection_is_over(error):
                return  # a handler that reads the socket has seen its end
            log.exception("! %s: handler for %s failed", self._name, format_address(*peer))
        finally:
            if not self._forget(sock):
                interrupt(sock)
                sock.close()

    def _forget(self, sock: socket.socket) -> bool:
        """Remove a connection whose handler has returned; return whether it was handed over."""
        with self._lock:
            self._threads.pop(sock, None)
            self._is_not_pending(sock)
            self._idle.pop(sock, None)
            return sock in self._handed_over
