"""One connected subscriber, seen from the publisher: a socket, an outbox, and when to use which.

The link is in one of three states, under its lock:

* direct: nothing waits; a message is sent at once, in the publisher's own thread.
* batch: messages come faster than a system call is worth; they are joined and sent together, after
  `BATCH_BYTES` or `BATCH_SECONDS`, by the next message that comes alone, or by the monitor a millisecond
  later.
* blocked: the socket is full. Messages go to the outbox, which drops the oldest; the monitor sends when the
  socket takes more. `send` itself never waits.

Writing each message alone costs a system call and a wake-up of the reader (177 k/s against 950 k/s,
measured); leaving it to Nagle's algorithm costs 40 ms now and then. So: TCP_NODELAY, and this.
"""

from __future__ import annotations

import socket
import sys
import threading
from collections.abc import Callable, Sequence
from time import perf_counter, sleep
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.node.outgoing.frames import LargeFrame, remaining
from rosproto.node.outgoing.link_monitor import LinkMonitor
from rosproto.node.outgoing.outbox import Outbox
from rosproto.transport.tcp import set_linger

if TYPE_CHECKING:
    from rosproto.node.stats import LinkStats

__all__ = ["SubscriberLink"]

BATCH_BYTES = 16 << 10
BATCH_SECONDS = 200e-6
RETRY_SECONDS = 500e-6  # publish() tries a blocked link this often itself: the monitor may not get to run
MOST_NAME = 1024  # characters of a peer's name
MOST_NOISE = 64 << 10  # bytes that a subscriber may send after its header
MOST_VIEWS = 64  # buffers for one sendmsg; IOV_MAX is 1024 on Linux, 16 at the least by POSIX


OnClosed = Callable[["SubscriberLink", "ConnectionLost | None"], None]


class SubscriberLink:
    """A subscriber that has been answered and now gets messages.

    Args:
        sock: The connection, the subscriber's header read; the link owns it and makes it non-blocking.
        header: The subscriber's connection header.
        address: "host:port" of the subscriber.
        topic: Resolved topic.
        queue_size: Most messages that wait for this subscriber; the oldest is dropped.
        monitor: The node's monitor.
        on_closed: Called once, from any thread and without a lock, when the link has ended.
        greeting: Our own connection header, which is sent before any message.

    Attributes:
        id: Number of the connection in getBusInfo.
        caller_id: The subscriber's node name.
    """

    transport = "TCPROS"

    __slots__ = (
        "_batch",
        "_batch_bytes",
        "_batch_due",
        "_blocked",
        "_bytes",
        "_closed",
        "_empty",
        "_error",
        "_lock",
        "_messages",
        "_monitor",
        "_noise",
        "_on_closed",
        "_outbox",
        "_promised",
        "_sending",
        "_tried",
        "_watched",
        "address",
        "caller_id",
        "id",
        "sock",
        "topic",
    )

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
        self.sock = sock
        self.address = address
        self.topic = topic
        self.id = id
        self.caller_id = header.get("callerid", "")[:MOST_NAME]
        self._monitor = monitor
        self._on_closed = on_closed
        self._lock = threading.RLock()  # a signal handler may publish, and interrupts what holds it
        self._sending = False  # under the lock: True is seen only by such a handler
        self._empty: threading.Condition | None = None  # made by who waits for it
        self._outbox = Outbox(queue_size)
        self._batch: list[bytes] = []
        self._batch_bytes = 0
        self._batch_due = 0.0
        self._promised = False  # the monitor will call `flush`
        self._blocked = False
        self._tried = 0.0
        self._noise = 0
        self._messages = 0
        self._bytes = 0
        self._closed = False
        self._watched = False  # the monitor knows the link
        self._error = ""
        sock.setblocking(False)
        if greeting:
            # As a message of which a part is sent: it is never dropped, and all others wait behind it.
            self._outbox.begin([memoryview(greeting)])
            self._blocked = True
            self._messages, self._bytes = -1, -len(greeting)

    def start(self) -> None:
        """Send the greeting, if no message has pushed it out yet, and let the monitor watch the socket."""
        with self._lock:
            self._watched = True
            self._monitor.add(self)
            error = self._drain() if self._blocked and not self._closed else None
            if self._blocked:
                self._monitor.want_write(self, True)
        if error is not None:
            self._end(error)

    def set_linger(self, linger: bool) -> None:
        """Whether the system delivers what is on its way when this program is killed."""
        set_linger(self.sock, linger)

    # -- sending --------------------------------------------------------------------------------------------

    def send(self, frame: bytes) -> None:
        """Send a small frame now, after what is in the batch, or put it in the outbox; never waits."""
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
            self._end(error)

    def _leave(self, frame: bytes) -> None:
        """A signal handler publishes while its thread is sending here: the monitor sends it in a moment."""
        self._batch.append(frame)
        self._batch_bytes += len(frame)
        if not self._promised:
            self._promised = True
            self._monitor.flush_later(self)

    def send_soon(self, frame: bytes, now: float) -> bool:
        """Add a small frame to the batch, and send the batch when it is due; never waits.

        No lock is taken for the batch: `append` is atomic, and whoever sends takes frames from the front.
        That no frame stays behind hangs on the order here and in `flush`: the frame is there before the
        promise is looked at, and the promise is taken back before the batch is. The bytes may be miscounted.

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
        """Send a frame in parts; what the socket does not take is copied. Never waits."""
        error = None
        with self._lock:
            if self._sending:
                self._leave(frame.owned())
                return
            self._sending = True
            try:
                if self._batch:
                    error = self._send_batch()
                elif self._blocked:
                    error = self._retry()
                if error is None:
                    if self._blocked:
                        self._outbox.put(frame.frozen())
                    else:
                        error = self._send_views(frame)
            finally:
                self._sending = False
        if error is not None:
            self._end(error)
        elif self._blocked:
            sleep(0)  # let the monitor, and on a busy computer the subscriber, get on

    def _send_batch(self) -> OSError | None:
        """Send what is in the batch, or move it to the outbox."""
        batch = self._batch[:]
        del self._batch[: len(batch)]
        self._batch_bytes = 0
        if self._blocked:
            for frame in batch:
                self._outbox.put(frame)
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
        """The socket is full after `sent` bytes of `frames`: the rest goes to the outbox."""
        outbox = self._outbox
        for frame in frames:
            if sent >= len(frame):
                sent -= len(frame)
                self._messages += 1
            elif sent:
                outbox.begin([memoryview(frame)[sent:]])
                sent = 0
            else:
                outbox.put(frame)
        self._watch_writing()

    def _send_views(self, frame: LargeFrame) -> OSError | None:
        sent, error = _send_some(self.sock, frame.views)
        if error is not None:
            return error
        self._bytes += sent
        if sent == frame.size:
            self._messages += 1
            return None
        if sent:
            self._outbox.begin(frame.rest(sent))
        else:
            self._outbox.put(frame.frozen())
        self._watch_writing()
        return None

    def _watch_writing(self) -> None:
        self._blocked = True
        self._tried = perf_counter()
        if self._watched:
            self._monitor.want_write(self, True)

    def _retry(self) -> OSError | None:
        """Try a blocked link from publish() itself: while the caller computes, nobody else gets to run."""
        now = perf_counter()
        if now - self._tried < RETRY_SECONDS:
            return None
        self._tried = now
        return self._drain()

    def _drain(self) -> OSError | None:
        """Send from the outbox until it is empty or the socket is full."""
        outbox = self._outbox
        while frames := outbox.take():
            size = sum(map(len, frames))
            if len(frames) > 1 and size < BATCH_BYTES * 8:
                frames = [b"".join(frames)]
            sent, error = _send_some(self.sock, frames)
            if error is not None:
                return error
            self._bytes += sent
            self._messages += outbox.sent(sent) if sent else 0
            if sent < size:
                return None
        self._blocked = False
        if self._watched:
            self._monitor.want_write(self, False)
        if self._empty is not None:
            self._empty.notify_all()
        return None

    # -- called by the monitor ------------------------------------------------------------------------------

    def flush(self) -> None:
        """Send the batch, if there is one, as promised."""
        self._promised = False
        self._flush()

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
            self._end(error)

    def on_writable(self) -> None:
        """The socket takes more."""
        with self._lock:
            error = None if self._closed else self._drain()
        if error is not None:
            self._end(error)

    def on_readable(self) -> None:
        """A subscriber says nothing after its header: this is its end. One that talks on is cut off."""
        try:
            noise = len(self.sock.recv(4096))
            self._noise += noise
            if noise and self._noise < MOST_NOISE:
                return
            error = OSError("it sends where it should listen") if noise else None
        except BlockingIOError:
            return
        except OSError as reset:
            error = reset
        self._end(error)

    # -- end ------------------------------------------------------------------------------------------------

    def wait_empty(self, timeout: float) -> None:
        """Wait until everything is handed to the operating system.

        In a signal handler that interrupted the sending here nothing can be waited for, so it is not.

        Raises:
            RosTimeout: The subscriber is too slow.
            ConnectionLost: It is gone.
        """
        self._flush()
        with self._lock:
            if self._sending:
                return
            self._empty = self._empty or threading.Condition(self._lock)
            if not self._empty.wait_for(lambda: self._closed or not self._outbox, timeout):
                raise RosTimeout(
                    f"{self.topic}: {len(self._outbox)} messages wait for {self.caller_id or self.address}"
                    f" after {timeout:g} s; the subscriber is slow or the network is",
                    what=f"subscriber {self.caller_id}",
                    seconds=timeout,
                )
            if self._closed and self._error:
                raise ConnectionLost(
                    f"{self.topic}: {self.caller_id} is gone: {self._error}", peer=self.address
                )

    def close(self, *, deliver: bool = True) -> None:
        """End the link; the outbox is dropped.

        Args:
            deliver: The operating system delivers what it has, and repeats it for a while where the network
                is away. False has it thrown away.
        """
        self._end(None, told=False, deliver=deliver)

    def _end(self, error: OSError | None, *, told: bool = True, deliver: bool = True) -> None:
        with self._lock:
            if self._closed:
                return
            if error is None:
                if self._batch and deliver and not self._sending:
                    self._send_batch()
                set_linger(self.sock, deliver)
            self._closed = True
            self._error = str(error) if error is not None else ""
            self._blocked = False
            self._outbox.dropped += self._outbox.clear()
            if self._empty is not None:
                self._empty.notify_all()
        try:
            if deliver:
                self.sock.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # the other side was faster
        # Not `tcp.interrupt`: nobody waits in this socket but the monitor's select, which must not lose it.
        self._monitor.remove(self)
        lost = None
        if told:
            why = f": {error}" if error is not None else ", it closed the connection"
            lost = ConnectionLost(
                f"{self.topic}: subscriber {self.caller_id} at {self.address} is gone{why}", peer=self.address
            )
        self._on_closed(self, lost)

    @property
    def queue_size(self) -> int:
        """Most messages that wait."""
        return self._outbox.size

    @queue_size.setter
    def queue_size(self, size: int) -> None:
        with self._lock:
            self._outbox.size = size

    def stats(self) -> LinkStats:
        """Counters so far."""
        from rosproto.node.stats import LinkStats

        with self._lock:
            return LinkStats(
                topic=self.topic,
                direction="out",
                peer=self.caller_id,
                address=self.address,
                transport=self.transport,
                connected=not self._closed,
                bytes=max(0, self._bytes),
                messages=max(0, self._messages),
                dropped=self._outbox.dropped,
                queued=len(self._outbox) + len(self._batch),
                state="closed" if self._closed else "blocked" if self._blocked else "connected",
                last_error=self._error,
            )

    def __repr__(self) -> str:
        return f"<SubscriberLink {self.topic} -> {self.caller_id} {self.address}>"


def _send_some(sock: socket.socket, views: Sequence[bytes | memoryview]) -> tuple[int, OSError | None]:
    """Send as much as the socket takes now: (bytes sent, error)."""
    total = 0
    try:
        if sys.platform != "win32":  # where there is no sendmsg
            rest: Sequence[bytes | memoryview] = views
            while rest:
                some = rest[:MOST_VIEWS]
                sent = sock.sendmsg(some)
                total += sent
                if sent < sum(map(len, some)):
                    # A signal or the buffer's end; either way the next try tells.
                    rest = [*remaining([memoryview(v) for v in some], sent), *rest[MOST_VIEWS:]]
                    continue
                rest = rest[MOST_VIEWS:]
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
