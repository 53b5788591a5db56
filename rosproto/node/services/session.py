"""One client's connection at a service provider: read a request, have it answered, in order.

Source: wiki.ros.org/ROS/TCPROS; rospy impl/tcpros_service.py and roscpp service_client_link.cpp.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable

from rosproto.errors import RemoteProtocolError
from rosproto.logs import PeerLog, get_logger
from rosproto.protocol.framing import FrameDecoder
from rosproto.protocol.limits import Limits
from rosproto.transport.socket_waits import limit_waits
from rosproto.transport.tcp import interrupt

logger = get_logger("rosproto.node")

ROOM = 4 << 10  # bytes; what most requests fit into
STEP = 256 << 10  # for a longer one: a thousand peers may announce it and send nothing


class ServiceSession:
    """Serves one connection whose headers are exchanged; `run` returns when it is over.

    Requests may be pipelined: they are answered one after the other. An idle connection may stay as long as
    it likes, but once a request has begun to arrive, or an answer to leave, `stall_seconds` without
    progress end it.

    Attributes:
        peer: "host:port" of the client.
        callerid: Its node name, "" when it did not say.
    """

    def __init__(
        self,
        sock: socket.socket,
        answer: Callable[[bytes], bytes],
        *,
        peer: str,
        callerid: str = "",
        persistent: bool,
        limits: Limits,
        stall_seconds: float = 30.0,
        said: PeerLog | None = None,
    ) -> None:
        self._sock = sock
        self._answer = answer
        self._persistent = persistent
        self._stall_seconds = stall_seconds
        self._requests = FrameDecoder(limits.message_bytes, room=ROOM, step=STEP)
        self._said = said or PeerLog("rosproto.node")
        self._lock = threading.Lock()
        self._changed = threading.Condition(self._lock)
        self._busy = False
        self._ending = False
        self._thread = threading.current_thread()
        self.peer = peer
        self.callerid = callerid

    def run(self) -> None:
        """Serve until the client leaves, breaks the protocol, or `finish`; then the socket is closed.

        A client that leaves is no event: one-shot clients, probes and port scans do it all the time.
        """
        self._thread = threading.current_thread()
        try:
            limit_waits(self._sock, self._stall_seconds)
            while (request := self._read_request()) is not None and self._begin():
                self._sock.sendall(self._answer(request))
                if not self._end() or not self._persistent:
                    break
        except RemoteProtocolError as error:
            self._said.warning("", "! service client %s %s: %s", self.callerid, self.peer, error)
        except OSError as error:
            logger.debug("! service client %s %s: %s", self.callerid, self.peer, error)
        finally:
            with self._lock:
                # Under the lock, and before close() takes the number away: who waits in `join` must find the
                # line cut when it returns.
                self._shutdown()
                self._busy, self._ending = False, True
                self._changed.notify_all()
            self._sock.close()

    def _read_request(self) -> bytes | None:
        """The next request; None when the client closed the connection."""
        requests = self._requests
        while True:
            if requests.buffered and (request := requests.next_frame()) is not None:
                return request
            try:
                count = self._sock.recv_into(requests.space())
            except (BlockingIOError, TimeoutError):
                if requests.buffered:
                    raise
                continue  # idle, not stalled
            if not count:
                return None
            if (request := requests.whole(count)) is not None:
                return request
            requests.received(count)

    def _begin(self) -> bool:
        with self._lock:
            self._busy = not self._ending
            return self._busy

    def _end(self) -> bool:
        with self._lock:
            self._busy = False
            if self._ending:
                self._changed.notify_all()
            return not self._ending

    def finish(self) -> None:
        """Ask the session to end: at once when idle, after the answer when a request is being served."""
        with self._lock:
            self._ending = True
            if not self._busy:
                self._shutdown()

    def join(self, timeout: float | None) -> bool:
        """Wait until the request in progress is answered; then, or when `timeout` is over, cut the line.

        Returns:
            False when the handler was still running; its thread is left behind (Python cannot end it) and
            its answer will go nowhere.
        """
        done = self._thread is threading.current_thread()  # closed by its own handler
        if not done:
            with self._changed:
                done = self._changed.wait_for(lambda: not self._busy, timeout)
                self._shutdown()
        return done

    def _shutdown(self) -> None:
        interrupt(self._sock)
