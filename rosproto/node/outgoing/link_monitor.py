"""One thread that monitors all subscriber links of a node.

`publish()` sends in the caller's thread while the socket is writable. This thread does the rest:

* it reads, because a subscriber's FIN or RST is only seen by reading;
* when a full socket becomes writable again, it has the link send its queue;
* it sends the last batch of a burst (`flush_later`);
* twice a second it checks the age of the unacknowledged bytes of each link (`Backlog`).

Only this thread uses the selector. Other threads put requests into a deque and wake it through a socket pair.
Where the system only has select(), which takes a few hundred sockets (Windows), additional sockets go to
another monitor with its own thread.

Bytes in the socket buffer cannot be withdrawn one by one. After a network outage of half a minute, the system
would still deliver them, such as velocities half a minute old. Resetting the connection discards all of them.
The monitor checks each link every `CHECK_SECONDS` and resets it when

* the oldest byte is older than `MAX_AGE_SECONDS` (small messages: velocities, states);
* or, with more than `BULK_BYTES` under way, no byte arrived for that long: a subscriber that is behind a
  burst still makes progress while it reads;
* or, with large messages (a map, images), no byte arrived and the other computer does not acknowledge: a
  subscriber that processes each image for long is only slow.
"""

from __future__ import annotations

import selectors
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from rosproto.logs import get_logger
from rosproto.transport.tcp import open_selector, wake_pair
from rosproto.transport.unsent_bytes import UnsentBytes

if TYPE_CHECKING:
    from rosproto.node.outgoing.queued_link import QueuedLink

_log = get_logger("rosproto.node")


CHECK_SECONDS = 0.5  # seconds between two checks; also the largest error of an age, and the detection delay
MAX_AGE_SECONDS = 4.0  # seconds; stays below five with the check interval and the network delay
BULK_BYTES = 256 << 10
_MAX_MARKS = 64


class Backlog:
    """The unacknowledged bytes of one link. No I/O here.

    Args:
        since: Seconds; the last time at which nothing was under way.
    """

    __slots__ = ("_acked", "_looked", "_marks", "_moved", "_since")

    def __init__(self, since: float) -> None:
        self._since = since  # the oldest byte was written after this
        self._moved = since  # when the last byte arrived
        self._looked = since
        self._acked: int | None = None
        self._marks: deque[tuple[float, int]] = deque(maxlen=_MAX_MARKS)

    def look(self, now: float, written: int, queue: UnsentBytes, *, large: bool) -> str:
        """Check the age of the bytes under way.

        Args:
            now: Seconds.
            written: Bytes written so far, including those in `queue`.
            queue: Unsent and unacknowledged bytes, as reported by the system.
            large: Whether large messages are among them.

        Returns:
            Why the connection should be reset; "" if it should not.
        """
        acked = written - queue.waiting
        if self._acked is None or acked > self._acked:
            if self._acked is not None:
                self._moved = now
            self._acked = acked
            while self._marks and self._marks[0][1] <= acked:
                self._since = self._marks.popleft()[0]
        self._marks.append((now, written))
        late, self._looked = now - self._looked > 2 * CHECK_SECONDS, now
        if late:  # this process was not scheduled, so ages are too high: wait for the next check
            return ""
        age, still = now - self._since, now - self._moved
        if large:
            stale = queue.in_flight and still >= MAX_AGE_SECONDS
        elif queue.waiting > BULK_BYTES:
            stale = still >= MAX_AGE_SECONDS
        else:
            stale = age >= MAX_AGE_SECONDS
        if not stale:
            return ""
        what = "its computer does not answer" if queue.in_flight else "it does not read"
        return f"{queue.waiting} bytes, the oldest {age:.1f} s old, have not arrived; {what}"


TICK_SECONDS = 0.001  # seconds; longest delay for the end of a burst, if this thread is scheduled
IDLE_TICKS = 20  # ticks without a batch before the thread sleeps again
MAX_SELECT_SOCKETS = 500  # sockets per thread; Windows' select() takes 512
MAX_SLEEP_SECONDS = 5.0  # seconds; bounds every wait


class LinkMonitor:
    """The monitor thread; started with the first link, ended by `close`."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._selector = open_selector(f"watch the links of {name}")
        try:
            self._wake_in, self._wake_out = wake_pair(f"watch the links of {name}")
        except BaseException:
            self._selector.close()
            raise
        self._wake_in.setblocking(False)
        self._wake_out.setblocking(False)
        self._selector.register(self._wake_in, selectors.EVENT_READ, None)
        self._requests: deque[Callable[[], None]] = deque()
        self._due: deque[QueuedLink] = deque()
        self._ticking = False
        self._closing = False
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()
        self._further: LinkMonitor | None = None
        self._elsewhere: set[QueuedLink] = set()  # watched by `_further`
        self._looked = time.monotonic()
        self._look_failed = False  # logged once

    # -- from any thread ------------------------------------------------------------------------------------

    def add(self, link: QueuedLink) -> None:
        """Watch a link; its socket must be non-blocking."""
        self._request(lambda: self._watch(link, selectors.EVENT_READ))

    def want_write(self, link: QueuedLink, wanted: bool) -> None:
        """Call `on_writable` whenever the socket is writable, until called again with False."""
        events = selectors.EVENT_READ | (selectors.EVENT_WRITE if wanted else 0)
        self._request(lambda: self._change(link, events))

    def remove(self, link: QueuedLink) -> None:
        """Stop watching, then close the socket.

        The monitor closes the socket itself: if the selector still held a file descriptor that was closed and
        reused, it would watch another connection.
        """
        self._request(lambda: self._drop(link))

    def flush_later(self, link: QueuedLink) -> None:
        """Call `link.flush()` about a millisecond from now."""
        self._due.append(link)
        if not self._ticking:
            self._ticking = True
            self._wake()

    def close(self, timeout: float = 2.0) -> None:
        """End the thread and close the sockets of links still watched."""
        with self._lock:
            self._closing = True
            thread = self._thread
        self._wake()
        if thread is not None and thread is not threading.current_thread():
            thread.join(timeout)
        if thread is None or not thread.is_alive():
            self._release()
        if self._further is not None:
            self._further.close(timeout)

    def _request(self, request: Callable[[], None]) -> None:
        with self._lock:
            if not self._closing:
                self._requests.append(request)
                if self._thread is None:
                    self._thread = threading.Thread(
                        target=self._run, name=f"rosproto:links {self._name}", daemon=True
                    )
                    self._thread.start()
                    return
        if self._closing:
            request()  # the thread is ending and does not use the selector any more
        elif threading.current_thread() is not self._thread:
            self._wake()

    def _wake(self) -> None:
        try:
            self._wake_out.send(b"\0")
        except OSError:
            pass  # full: already being woken; closed: ending

    # -- in the thread --------------------------------------------------------------------------------------

    def _run(self) -> None:
        idle = 0
        while not self._closing:
            while self._requests:
                self._requests.popleft()()
            sleep = (
                CHECK_SECONDS if len(self._selector.get_map()) > 1 else MAX_SLEEP_SECONDS
            )  # without links: no check
            ready = self._selector.select(TICK_SECONDS if self._ticking else sleep)
            for key, events in ready:
                self._serve(key.data, events)
            idle = 0 if self._flush_due() else idle + 1
            self._look()
            if self._ticking and idle > IDLE_TICKS:
                self._ticking = False
                # A link added before `_ticking` was cleared did not wake this thread.
                self._ticking = bool(self._due)

    def _serve(self, link: QueuedLink | None, events: int) -> None:
        if link is None:
            try:
                self._wake_in.recv(4096)
            except OSError:
                pass  # drained already
            return
        try:
            if events & selectors.EVENT_READ:
                link.on_readable()
            if events & selectors.EVENT_WRITE:
                link.on_writable()
        except Exception:
            _log.exception("! a link failed unexpectedly: %r", link)
            self._drop(link)

    def _flush_due(self) -> bool:
        count = len(self._due)
        for _ in range(count):
            self._due.popleft().flush()
        return bool(count)

    def _look(self) -> None:
        now, before = time.monotonic(), self._looked
        if now - before < CHECK_SECONDS:
            return
        self._looked = now
        for key in list(self._selector.get_map().values()):
            if key.data is not None:
                try:
                    key.data.look(now, before)
                except Exception:  # the link stays: a zero velocity may be the next message
                    if not self._look_failed:
                        _log.exception("! the age of unsent bytes cannot be determined: %r", key.data)
                    self._look_failed = True

    def _watch(self, link: QueuedLink, events: int) -> None:
        selector = self._selector
        if isinstance(selector, selectors.SelectSelector) and len(selector.get_map()) > MAX_SELECT_SOCKETS:
            self._watch_elsewhere(link, events)
            return
        try:
            self._selector.register(link.sock, events, link)
        except (ValueError, KeyError, OSError) as error:
            _log.debug("! not watched, already closed: %r: %s", link, error)

    def _watch_elsewhere(self, link: QueuedLink, events: int) -> None:
        if self._further is None:
            self._further = LinkMonitor(f"{self._name}+")
        self._elsewhere.add(link)
        self._further.add(link)
        if events & selectors.EVENT_WRITE:
            self._further.want_write(link, True)

    def _change(self, link: QueuedLink, events: int) -> None:
        if link in self._elsewhere:
            assert self._further is not None
            self._further.want_write(link, bool(events & selectors.EVENT_WRITE))
            return
        try:
            self._selector.modify(link.sock, events, link)
        except KeyError:
            # A latched message filled the socket before it was added. (A removed link has a closed socket.)
            self._watch(link, events)
        except (ValueError, OSError):
            pass  # removed meanwhile

    def _drop(self, link: QueuedLink) -> None:
        if link in self._elsewhere:
            assert self._further is not None
            self._elsewhere.discard(link)
            self._further.remove(link)
            return
        try:
            self._selector.unregister(link.sock)
        except (ValueError, KeyError, OSError):
            pass  # never watched, or dropped twice
        link.sock.close()

    def _release(self) -> None:
        with self._lock:
            requests, self._requests = self._requests, deque()
        if self._selector.get_map() is None:
            return
        for request in requests:
            request()
        for key in list(self._selector.get_map().values()):
            if key.data is not None:
                key.data.sock.close()
        self._selector.close()
        self._wake_in.close()
        self._wake_out.close()
