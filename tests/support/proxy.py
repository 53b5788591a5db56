"""A TCP proxy that breaks connections on command: put it between two real peers.

with FaultProxy("127.0.0.1", server.port) as proxy:
    client = connect("127.0.0.1", proxy.port)
    proxy.reset()          # every open connection ends with RST on both sides
    proxy.stall()          # no bytes are forwarded until resume(), also of new connections
    proxy.byte_at_a_time = True
    proxy.cut_after(10)    # each open connection ends after 10 more bytes
"""

from __future__ import annotations

import selectors
import socket
import struct
import sys
import threading
import time
from contextlib import suppress

_LINGER_RESET = struct.pack("hh" if sys.platform == "win32" else "ii", 1, 0)


class FaultProxy:
    """Forwards connections to a target, with faults. All faults act on both directions.

    Attributes:
        host: Where it listens (always 127.0.0.1).
        port: Its port.
        byte_at_a_time: Forward single bytes, each in a segment of its own.
        refusing: Close new connections at once.
        accepted: Connections taken so far.
        forwarded: Bytes passed on so far, both directions together.
    """

    def __init__(self, target_host: str, target_port: int) -> None:
        self._target = (target_host, target_port)
        self._lock = threading.Lock()
        self._links: set[_Link] = set()
        self._running = threading.Event()  # cleared: stalled
        self._running.set()
        self._closed = threading.Event()
        self._delay = 0.0
        self.byte_at_a_time = False
        self.refusing = False
        self.accepted = 0
        self.forwarded = 0
        self._listener = socket.create_server(("127.0.0.1", 0), backlog=128)
        self._listener.setblocking(False)
        self.host, self.port = self._listener.getsockname()
        self._wake, self._waker = socket.socketpair()
        self._thread = threading.Thread(target=self._accept, name="fault proxy", daemon=True)
        self._thread.start()

    def __enter__(self) -> FaultProxy:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def connections(self) -> int:
        """Connections open now."""
        with self._lock:
            return len(self._links)

    def retarget(self, host: str, port: int) -> None:
        """New connections go there (a restarted peer)."""
        self._target = (host, port)

    def cut(self) -> None:
        """End every connection in an orderly way (FIN) on both sides."""
        for link in self._take_links():
            link.end(reset=False)

    def reset(self) -> None:
        """End every connection with RST on both sides."""
        for link in self._take_links():
            link.end(reset=True)

    def cut_after(self, size: int) -> None:
        """End each open connection (FIN) after `size` more bytes, counted over both directions."""
        with self._lock:
            for link in self._links:
                link.left = size

    def stall(self) -> None:
        """Forward nothing; connections stay open, as when the cable is pulled."""
        self._running.clear()

    def resume(self) -> None:
        """Forward again, beginning with what waited."""
        self._running.set()

    def delay(self, seconds: float) -> None:
        """Hold every piece of data back for so long."""
        self._delay = seconds

    def close(self) -> None:
        """Stop listening and end every connection."""
        if not self._closed.is_set():
            self._closed.set()
            self._running.set()
            self._waker.send(b"x")
            self._thread.join(5)
            self._wake.close()  # not by the thread: it may end before the byte above is sent
            self._waker.close()
            self.cut()

    def _take_links(self) -> list[_Link]:
        with self._lock:
            links, self._links = list(self._links), set()
        return links

    def _accept(self) -> None:
        with selectors.DefaultSelector() as selector, self._listener:
            selector.register(self._listener, selectors.EVENT_READ)
            selector.register(self._wake, selectors.EVENT_READ)
            while not self._closed.is_set():
                selector.select()
                with suppress(OSError):
                    client, _ = self._listener.accept()
                    self.accepted += 1
                    self._open(client)

    def _open(self, client: socket.socket) -> None:
        client.setblocking(True)
        if self.refusing:
            client.close()
            return
        try:
            server = socket.create_connection(self._target, 5)
        except OSError:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _LINGER_RESET)
            client.close()
            return
        server.settimeout(None)
        link = _Link(self, client, server)
        with self._lock:
            self._links.add(link)
        link.start()


class _Link:
    """One connection through the proxy: two sockets, two threads."""

    def __init__(self, proxy: FaultProxy, client: socket.socket, server: socket.socket) -> None:
        self._proxy = proxy
        self._sockets = (client, server)
        self._open_directions = 2
        self._lock = threading.Lock()
        self.left: int | None = None
        self._ended = False
        for sock in self._sockets:
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def start(self) -> None:
        client, server = self._sockets
        for pair in ((client, server), (server, client)):
            threading.Thread(target=self._pump, args=pair, name="fault proxy pump", daemon=True).start()

    def end(self, *, reset: bool) -> None:
        self._ended = True  # before a pump wakes up: its FIN must not come before our RST
        for sock in self._sockets:
            with suppress(OSError):
                if reset:
                    sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _LINGER_RESET)
                    # closing alone would wait for the pump's recv; reading is ended first, which sends nothing
                    sock.shutdown(socket.SHUT_RD)
                else:
                    sock.shutdown(socket.SHUT_RDWR)
            sock.close()

    def _pump(self, source: socket.socket, sink: socket.socket) -> None:
        proxy = self._proxy
        with suppress(OSError):
            while data := source.recv(65536):
                if proxy._delay:
                    time.sleep(proxy._delay)
                proxy._running.wait()
                if not self._forward(sink, data):
                    self.end(reset=False)
                    break
            if not self._ended:
                sink.shutdown(socket.SHUT_WR)
        self._direction_ended()

    def _forward(self, sink: socket.socket, data: bytes) -> bool:
        with self._lock:
            if self.left is not None:
                data = data[: self.left]
                self.left -= len(data)
        self._proxy.forwarded += len(data)  # before they can be received, so that tests read the right number
        if self._proxy.byte_at_a_time:
            for number in range(len(data)):
                sink.sendall(data[number : number + 1])
        else:
            sink.sendall(data)
        return self.left is None or self.left > 0

    def _direction_ended(self) -> None:
        with self._lock:
            self._open_directions -= 1
            over = self._open_directions == 0
        if over:
            with self._proxy._lock:
                self._proxy._links.discard(self)
            for sock in self._sockets:
                sock.close()
