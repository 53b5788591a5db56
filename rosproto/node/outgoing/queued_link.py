"""Base of the TCPROS and UDPROS links to subscribers: state, queue, counters, end.

`SubscriberLink` writes a stream and joins small messages of a burst; `DatagramLink` splits each message into
datagrams. Both send in the publisher's own thread while the socket is writable. Then they queue, and the
monitor continues.

A link is made when a subscriber's header is accepted. It joins the publication's links before the monitor
watches its socket, so that it gets everything published from then on; until then ("opening") only `publish()`
sends. Over TCPROS our header goes first and is queued. After that a link is either "connected", with an empty
queue: messages are sent at once, or joined into a batch; or "blocked": the socket is full, messages go to the
queue, and the monitor sends when the socket is writable. "closed" is final: a subscriber that connects again
gets another link.

Drop policy: at most `size` whole messages are queued; a new one displaces the oldest. A partly sent message
is always completed, else the stream would lose its framing.
"""

from __future__ import annotations

import socket
import threading
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.node.outgoing.frames import Frame, LargeFrame, remaining
from rosproto.node.outgoing.link_monitor import LinkMonitor
from rosproto.node.stats import LinkStats

BATCH = 64 << 10  # bytes joined for one send: more gains nothing (measured)


class FrameQueue:
    """A bounded queue of frames for one subscriber; drops the oldest.

    No I/O here: the link sends the frames from `take` and reports the bytes written with `sent`.

    Attributes:
        size: Largest number of whole frames.
        dropped: Frames dropped so far.
    """

    __slots__ = ("_begun", "_frames", "dropped", "size")

    def __init__(self, size: int) -> None:
        self.size = size
        self.dropped = 0
        self._frames: deque[Frame] = deque()
        self._begun: list[memoryview] = []

    def put(self, frame: Frame) -> None:
        """Add a frame; drop the oldest if there are too many."""
        self._frames.append(frame)
        if len(self._frames) > self.size:
            self._frames.popleft()
            self.dropped += 1

    def begin(self, rest: Iterable[memoryview]) -> None:
        """Put the rest of a partly sent frame before all others."""
        assert not self._begun, "one frame is begun at a time"
        self._begun = [view for view in rest if view.nbytes]

    def take(self) -> list[bytes | memoryview]:
        """Next data to send: the partly sent frame, or whole frames (about `BATCH` bytes); [] when empty."""
        if self._begun:
            return list(self._begun)
        batch: list[bytes | memoryview] = []
        size = 0
        for frame in self._frames:
            if isinstance(frame, LargeFrame):
                return batch or list(frame.views)
            size += len(frame)
            if batch and size > BATCH:
                break
            batch.append(frame)
        return batch

    def sent(self, count: int) -> int:
        """Record that the first `count` bytes of the last `take` were sent.

        Returns:
            Number of frames completed.
        """
        if self._begun:
            self._begun = remaining(self._begun, count)
            return 0 if self._begun else 1
        done = 0
        while count:
            frame = self._frames.popleft()
            if len(frame) > count:
                views = frame.views if isinstance(frame, LargeFrame) else [memoryview(frame)]
                self._begun = remaining(views, count)
                break
            count -= len(frame)
            done += 1
        return done

    def pop(self) -> bytes | None:
        """Remove and return the oldest frame; None when empty."""
        if not self._frames:
            return None
        frame = self._frames.popleft()
        return frame.owned() if isinstance(frame, LargeFrame) else frame

    def clear(self) -> int:
        """Drop all frames after the link has ended; return their number."""
        lost = len(self._frames) + bool(self._begun)
        self._frames.clear()
        self._begun = []
        return lost

    def __len__(self) -> int:
        return len(self._frames) + bool(self._begun)


OnClosed = Callable[[Any, "ConnectionLost | None"], None]


class QueuedLink:
    """A subscriber behind a socket; the base of the links that have one.

    Args:
        sock: The socket to the subscriber; the link owns it and makes it non-blocking.
        caller_id: The subscriber's node name.
        address: "host:port" of the subscriber.
        topic: Resolved topic.
        id: Number of the connection in getBusInfo.
        queue_size: Queue length; when full, the oldest message is dropped.
        monitor: The node's monitor.
        on_closed: Called once, from any thread and without a lock, when the link has ended.
    """

    transport = ""

    def __init__(
        self,
        sock: socket.socket,
        *,
        caller_id: str,
        address: str,
        topic: str,
        id: int,
        queue_size: int,
        monitor: LinkMonitor,
        on_closed: OnClosed,
    ) -> None:
        self.sock = sock
        self.caller_id = caller_id
        self.address = address
        self.topic = topic
        self.id = id
        self._monitor = monitor
        self._on_closed = on_closed
        self._lock = threading.RLock()  # reentrant: a signal handler may publish while its thread holds it
        self._sending = False  # guarded by the lock: only such a handler sees True
        self._empty: threading.Condition | None = None  # created by the first waiter
        self._queue = FrameQueue(queue_size)
        self._watched = False  # by the monitor
        self._blocked = False  # data waits for the socket, so new messages are queued behind it
        self._closed = False
        self._messages = 0
        self._bytes = 0
        self._error = ""
        self._failure: OSError | None = None
        sock.setblocking(False)

    def _set_blocked(self, blocked: bool) -> None:
        """Note whether data waits for the socket, and update the monitor's events; the lock is held.

        A closed link ignores it: a signal handler may close the link on which its own thread is sending.
        """
        if self._closed:
            return
        if self._watched and blocked != self._blocked:
            self._monitor.want_write(self, blocked)
        self._blocked = blocked
        if not blocked:
            self._wake_waiters()

    def _wake_waiters(self) -> None:
        if self._empty is not None:
            self._empty.notify_all()

    @property
    def _state(self) -> str:
        if self._closed:
            return "closed"
        if not self._watched:
            return "opening, blocked" if self._blocked else "opening"
        return "blocked" if self._blocked else "connected"

    def start(self) -> None:
        """Have the monitor watch the socket and send the queue."""
        with self._lock:
            if self._closed:
                return
            self._monitor.add(self)
            self._watched = True
            error = None
            if self._blocked:
                error = self._drain()
                if self._blocked:
                    self._monitor.want_write(self, True)
        if error is not None:
            self._end(error)

    # -- what the two kinds do in their own way -------------------------------------------------------------

    def _drain(self) -> OSError | None:
        """Send until the queue is empty or the socket is full; return an error that ends the link."""
        raise NotImplementedError

    @property
    def _queued(self) -> int:
        """Number of queued messages."""
        return len(self._queue)

    def _fail(self, error: OSError) -> None:
        """Have the monitor end the link after a failed write.

        Ending a link takes the topic's lock, writes to the log and may start a thread. `publish` must not
        wait for that: its message may be a stop command.
        """
        self._failure = self._failure or error
        if not self._closed:
            self._monitor.flush_later(self)

    def _before_end(self, error: OSError | None, deliver: bool) -> None:
        """Prepare the end of the link; the lock is held."""

    def _hang_up(self, deliver: bool) -> None:
        """Have the monitor close the socket of an ended link.

        The socket is not interrupted (`tcp.interrupt`): only the monitor's select waits for it and must not
        lose it.
        """
        self._monitor.remove(self)

    def _farewell(self, error: OSError | None) -> str:
        """Reason of an end that we did not cause."""
        raise NotImplementedError

    # -- called by the monitor ------------------------------------------------------------------------------

    def flush(self) -> None:
        """Send delayed messages; end the link if a write has failed."""
        if self._failure is not None:
            self._end(self._failure)

    def look(self, now: float, before: float) -> None:
        """Check the bytes under way.

        Args:
            now: `time.monotonic()`.
            before: Time of the previous check.
        """

    def on_readable(self) -> None:
        """Handle data or an error of the socket."""
        raise NotImplementedError

    def on_writable(self) -> None:
        """Continue sending: the socket is writable."""
        with self._lock:
            error = self._drain() if self._blocked else None
        if error is not None:
            self._end(error)

    # -- waiting, end, counters -----------------------------------------------------------------------------

    def has_arrived(self) -> bool | None:
        """Whether the subscriber's computer has received all bytes; None if unknown."""
        return None

    def wait_empty(self, timeout: float) -> None:
        """Wait until the operating system has accepted everything.

        Returns at once in a signal handler that interrupted a send of this link.

        Raises:
            RosTimeout: The subscriber is too slow.
            ConnectionLost: It is gone.
        """
        self.flush()
        with self._lock:
            if self._sending:
                return
            self._empty = self._empty or threading.Condition(self._lock)
            if not self._empty.wait_for(lambda: not self._blocked, timeout):
                raise RosTimeout(
                    f"{self.topic}: {len(self._queue)} messages wait for {self.caller_id or self.address}"
                    f" after {timeout:g} s; the subscriber or the network is slow",
                    what=f"subscriber {self.caller_id}",
                    seconds=timeout,
                )
            if self._closed and self._error:
                raise ConnectionLost(
                    f"{self.topic}: {self.caller_id} is gone: {self._error}", peer=self.address
                )

    def end_sending(self) -> bool:
        """Say that nothing more comes; return whether the subscriber disconnects when it has read that."""
        return False

    def close(self, *, deliver: bool = True) -> None:
        """End the link and drop its queue.

        Args:
            deliver: The operating system still delivers accepted bytes, and retransmits for a while during a
                network outage. False discards them.
        """
        self._end(None, report=False, deliver=deliver)

    def _end(self, error: OSError | None, *, report: bool = True, deliver: bool = True) -> None:
        with self._lock:
            if self._closed:
                return
            self._before_end(error, deliver)
            self._error = str(error) if error is not None else ""
            self._queue.dropped += self._queue.clear()
            self._closed, self._blocked = True, False
            self._wake_waiters()
        self._hang_up(deliver)
        lost = None
        if report:
            lost = ConnectionLost(
                f"{self.topic}: subscriber {self.caller_id} at {self.address} {self._farewell(error)}",
                peer=self.address,
            )
        self._on_closed(self, lost)

    @property
    def queue_size(self) -> int:
        """Queue length."""
        return self._queue.size

    @queue_size.setter
    def queue_size(self, size: int) -> None:
        with self._lock:
            self._queue.size = size

    def stats(self) -> LinkStats:
        """Counters of this side of the link."""
        with self._lock:
            return LinkStats(
                topic=self.topic,
                direction="out",
                peer=self.caller_id,
                address=self.address,
                transport=self.transport,
                connected=not self._closed and self._failure is None,
                bytes=max(0, self._bytes),
                messages=max(0, self._messages),
                dropped=self._queue.dropped,
                queued=self._queued,
                state=self._state,
                last_error=self._error,
            )

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.topic} -> {self.caller_id} {self.address}>"
