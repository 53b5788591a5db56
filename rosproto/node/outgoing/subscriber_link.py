"""The publisher's side of one TCPROS connection to a subscriber: a socket and a queue.

Its states are those of `QueuedLink`. In a burst, small messages are joined into a batch. The batch is sent
after `BATCH_BYTES` or `BATCH_SECONDS`, with the next message outside a burst, or by the monitor a
millisecond later. `send` never waits.

Writing each message alone costs a system call and a wake-up of the reader (177 k/s against 950 k/s,
measured); leaving it to Nagle's algorithm costs 40 ms now and then. Hence TCP_NODELAY and batches.
"""

from __future__ import annotations

import errno
import socket
import sys
from collections.abc import Sequence
from time import perf_counter, sleep

from rosproto.node.outgoing.frames import LargeFrame, remaining
from rosproto.node.outgoing.link_monitor import CHECK_SECONDS, MAX_AGE_SECONDS, Backlog, LinkMonitor
from rosproto.node.outgoing.queued_link import OnClosed, QueuedLink
from rosproto.transport.tcp import allow_repair, expect_acknowledgement, set_linger
from rosproto.transport.unsent_bytes import unsent_bytes

MAX_VIEWS = 64  # buffers for one sendmsg; IOV_MAX is 1024 on Linux, 16 at the least by POSIX


def send_some(sock: socket.socket, views: Sequence[bytes | memoryview]) -> tuple[int, OSError | None]:
    """Send as much as the socket takes now: (bytes sent, error)."""
    total = 0
    try:
        if sys.platform != "win32":  # which has no sendmsg
            rest: Sequence[bytes | memoryview] = views
            while rest:
                some = rest[:MAX_VIEWS]
                sent = sock.sendmsg(some)
                total += sent
                if sent < sum(map(len, some)):
                    # Interrupted by a signal, or the buffer is full; the next attempt decides.
                    rest = [*remaining([memoryview(v) for v in some], sent), *rest[MAX_VIEWS:]]
                    continue
                rest = rest[MAX_VIEWS:]
            return total, None
        for view in views:
            view = memoryview(view)
            while view:
                sent = sock.send(view)
                total += sent
                view = view[sent:]
    except BlockingIOError:
        pass
    except OSError as error:
        return total, error
    return total, None


BATCH_BYTES = 16 << 10
BATCH_SECONDS = 200e-6
RETRY_SECONDS = 500e-6  # publish() retries a blocked link this often, as the monitor may not be scheduled
MAX_NAME = 1024  # characters of a peer's name
MAX_NOISE = 64 << 10  # bytes that a subscriber may send after its header

# Errors of a system that has given up sending; Windows also uses the second one (WSAECONNABORTED).
_GAVE_UP = (errno.ETIMEDOUT, errno.ECONNABORTED, getattr(errno, "WSAETIMEDOUT", errno.ETIMEDOUT))


class SubscriberLink(QueuedLink):
    """A link to a subscriber whose header was accepted.

    Args (the others are those of `QueuedLink`):
        header: The subscriber's connection header.
        greeting: Our connection header, sent before any message.

    Attributes:
        reset_ends: Local and remote address of a connection that was reset because its backlog was too old;
            None otherwise.
    """

    transport = "TCPROS"

    def __init__(
        self,
        sock: socket.socket,
        header: dict[str, str],
        *,
        address: str,
        topic: str,
        queue_size: int,
        monitor: LinkMonitor,
        on_closed: OnClosed,
        id: int = 0,
        greeting: bytes = b"",
    ) -> None:
        super().__init__(
            sock,
            caller_id=header.get("callerid", "")[:MAX_NAME],
            address=address,
            topic=topic,
            id=id,
            queue_size=queue_size,
            monitor=monitor,
            on_closed=on_closed,
        )
        self._batch: list[bytes] = []
        self._batch_bytes = 0
        self._batch_due = 0.0
        self._promised = False  # whether the monitor will call `flush`
        self._tried = 0.0
        self._noise = 0
        self._backlog: Backlog | None = None  # set while bytes are under way
        self._large = False  # whether they may include a large message
        self._seen = -len(greeting)  # `_bytes` when nothing was under way
        self._repairing_since: float | None = None  # while the system sends lost bytes again
        self.reset_ends: tuple[tuple[str, int], tuple[str, int]] | None = None
        # After the system itself has ended a connection, it no longer reports the two addresses.
        self._ends = _ends(sock) if expect_acknowledgement(sock, round(MAX_AGE_SECONDS)) else None
        if greeting:
            # Like a partly sent message, it is never dropped, and all others wait behind it.
            self._queue.begin([memoryview(greeting)])
            self._set_blocked(True)
            self._messages, self._bytes = -1, -len(greeting)

    def set_linger(self, linger: bool) -> None:
        """Set whether the system still delivers sent messages after this program is killed."""
        set_linger(self.sock, linger)

    # -- sending --------------------------------------------------------------------------------------------

    def send(self, frame: bytes) -> None:
        """Send a small frame now, after the batch, or queue it; never waits."""
        error = None
        with self._lock:
            if self._sending:
                self._leave(frame)
                return
            self._sending = True
            try:
                if self._blocked or self._batch:
                    self._batch.append(frame)
                    error = self._send_batch()
                else:
                    sent = self.sock.send(frame)
                    self._bytes += sent
                    if sent == len(frame):
                        self._messages += 1
                    else:
                        self._block([frame], sent)
            except BlockingIOError:
                self._block([frame], 0)
            except OSError as broken:
                error = broken
            finally:
                self._sending = False
        if error is not None:
            self._fail(error)

    def _leave(self, frame: bytes) -> None:
        """Leave a frame to the monitor: a signal handler published while its own thread was sending here."""
        self._batch.append(frame)
        self._batch_bytes += len(frame)
        if not self._promised:
            self._promised = True
            self._monitor.flush_later(self)

    def send_soon(self, frame: bytes, now: float) -> bool:
        """Add a small frame to the batch, and send the batch when it is due; never waits.

        The batch needs no lock: `append` is atomic, and senders take frames from the front. No frame is lost
        because of the order here and in `flush`: the frame is appended before `_promised` is read, and
        `_promised` is cleared before the batch is taken. The byte count may be inexact.

        Args:
            frame: A whole frame with its length.
            now: `perf_counter()`.

        Returns:
            True when something was sent.
        """
        batch = self._batch
        batch.append(frame)
        size = self._batch_bytes = self._batch_bytes + len(frame)
        if self._promised:
            if size < BATCH_BYTES and now < self._batch_due:
                return False
            if size == len(frame):  # the first one
                self._batch_due = now + BATCH_SECONDS
                return False
        else:
            self._batch_due = now + BATCH_SECONDS
            self._promised = True
            self._monitor.flush_later(self)
            return False
        self._flush()
        if self._blocked:
            sleep(0)  # as in send_large
        return True

    def send_large(self, frame: LargeFrame) -> None:
        """Send a frame in parts; the unsent rest is copied. Never waits."""
        error = None
        with self._lock:
            if self._sending:
                self._leave(frame.owned())
                return
            self._sending = self._large = True
            try:
                if self._batch:
                    error = self._send_batch()
                elif self._blocked:
                    error = self._retry()
                if error is None:
                    if self._blocked:
                        self._queue.put(frame.frozen())
                    else:
                        error = self._send_views(frame)
            finally:
                self._sending = False
        if error is not None:
            self._fail(error)
        elif self._blocked:
            sleep(0)  # let the monitor run, and on a busy computer the subscriber

    def _send_batch(self) -> OSError | None:
        """Send the batch, or move it to the queue."""
        batch = self._batch[:]
        del self._batch[: len(batch)]
        self._batch_bytes = 0
        if self._blocked:
            for frame in batch:
                self._queue.put(frame)
            return self._retry()
        data = b"".join(batch)
        try:
            sent = self.sock.send(data)
        except BlockingIOError:
            sent = 0
        except OSError as error:
            return error
        self._bytes += sent
        if sent == len(data):
            self._messages += len(batch)
        else:
            self._block(batch, sent)
        return None

    def _block(self, frames: Sequence[bytes], sent: int) -> None:
        """Queue the rest of `frames` after `sent` bytes: the socket is full."""
        queue = self._queue
        for frame in frames:
            if sent >= len(frame):
                sent -= len(frame)
                self._messages += 1
            elif sent:
                queue.begin([memoryview(frame)[sent:]])
                sent = 0
            else:
                queue.put(frame)
        self._wait_for_room()

    def _send_views(self, frame: LargeFrame) -> OSError | None:
        sent, error = send_some(self.sock, frame.views)
        if error is not None:
            return error
        self._bytes += sent
        if sent == frame.size:
            self._messages += 1
            return None
        if sent:
            self._queue.begin(frame.rest(sent))
        else:
            self._queue.put(frame.frozen())
        self._wait_for_room()
        return None

    def _wait_for_room(self) -> None:
        self._tried = perf_counter()
        self._set_blocked(True)

    def _retry(self) -> OSError | None:
        """Retry a blocked link in publish(): while the caller computes, other threads may not run."""
        now = perf_counter()
        if now - self._tried < RETRY_SECONDS:
            return None
        self._tried = now
        return self._drain()

    def _drain(self) -> OSError | None:
        """Send from the queue until it is empty or the socket is full."""
        queue = self._queue
        while frames := queue.take():
            size = sum(map(len, frames))
            if len(frames) > 1 and size < BATCH_BYTES * 8:
                frames = [b"".join(frames)]
            sent, error = send_some(self.sock, frames)
            if error is not None:
                return error
            self._bytes += sent
            self._messages += queue.sent(sent) if sent else 0
            if sent < size:
                return None
        self._set_blocked(False)
        return None

    # -- called by the monitor ------------------------------------------------------------------------------

    def flush(self) -> None:
        """Send the batch, if there is one; see also `QueuedLink.flush`."""
        self._promised = False
        self._flush()
        super().flush()

    def _flush(self) -> None:
        error = None
        with self._lock:
            if self._batch and not self._closed and not self._sending:
                self._sending = True
                try:
                    error = self._send_batch()
                finally:
                    self._sending = False
        if error is not None:
            self._fail(error)

    def on_readable(self) -> None:
        """Handle the end of the connection; a subscriber that sends data after its header is disconnected."""
        try:
            noise = len(self.sock.recv(4096))
            self._noise += noise
            if noise and self._noise < MAX_NOISE:
                return
            error = OSError("it sent data on a receive-only connection") if noise else None
        except BlockingIOError:
            return
        except OSError as reset:
            error = reset
        self._end(self._failure or error)

    def has_arrived(self) -> bool | None:
        """Whether the subscriber's computer has received all bytes, or is gone."""
        with self._lock:
            if self._closed:
                return True
            if self._queued:
                return False
            queue = unsent_bytes(self.sock)
        return None if queue is None else not queue.waiting

    def look(self, now: float, before: float) -> None:
        """Reset the connection when its backlog is too old (`Backlog`)."""
        with self._lock:
            written = self._bytes
            if self._closed or (self._backlog is None and written == self._seen):
                return
            queue = unsent_bytes(self.sock)
            if queue is None or not queue.waiting:
                self._backlog, self._seen, self._large = None, written, False
                self._note_repair(False, now)
                return
            self._note_repair(queue.repairing, now)
            if self._backlog is None:
                self._backlog = Backlog(max(before, now - 2 * CHECK_SECONDS))
            why = self._backlog.look(now, written, queue, large=self._large)
        if why:
            self._reset(why)

    def _note_repair(self, repairing: bool, now: float) -> None:
        """Leave it to `look` to end a link on a network that loses bytes all the time; the lock is held.

        The system's own limit still applies to a program that was stopped or killed.
        """
        since = self._repairing_since
        if repairing:
            since = self._repairing_since = now if since is None else since
            allow_repair(self.sock, now - since)
        elif since is not None:
            self._repairing_since = None
            allow_repair(self.sock, 0.0)

    def _reset(self, why: str) -> None:
        """Discard all unsent bytes, here and in the system; the subscriber may connect again."""
        self.reset_ends = _ends(self.sock)
        set_linger(self.sock, False)
        self._end(OSError(why), deliver=False)

    # -- end ------------------------------------------------------------------------------------------------

    @property
    def _queued(self) -> int:
        return len(self._queue) + len(self._batch)

    def _before_end(self, error: OSError | None, deliver: bool) -> None:
        if error is not None and error.errno in _GAVE_UP and self._ends is not None:
            self.reset_ends = self._ends
        if error is None:
            if self._batch and deliver and not self._sending:
                self._send_batch()
            set_linger(self.sock, deliver)

    def end_sending(self) -> bool:
        """See `QueuedLink.end_sending`."""
        self._flush()
        with self._lock:
            if self._closed or self._blocked:
                return False
            try:
                self.sock.shutdown(socket.SHUT_WR)
            except OSError:
                pass  # the other side closed first; the monitor sees it
            return True

    def _hang_up(self, deliver: bool) -> None:
        if deliver:
            try:
                self.sock.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass  # the other side closed first
        super()._hang_up(deliver)

    def _farewell(self, error: OSError | None) -> str:
        return f"is gone: {error}" if error is not None else "is gone, it closed the connection"


def _ends(sock: socket.socket) -> tuple[tuple[str, int], tuple[str, int]] | None:
    """Local and remote address; None when the connection has ended."""
    try:
        return sock.getsockname(), sock.getpeername()
    except OSError:
        return None
