"""One thread for all subscribers of a node: who is gone, who can take more, whose batch is due.

`publish()` sends in the caller's thread whenever the socket takes it. What is left is this thread's work:

* a subscriber's FIN or RST is only seen by reading, and subscribers never send anything to read;
* a socket that was full becomes writable again: the link sends what waits in its queue;
* the last messages of a burst sit in a batch which nobody else would send (`flush_later`);
* what a socket took may not arrive: twice a second each link looks how old that is (`Backlog`).

The selector belongs to the thread alone; others leave requests in a deque and wake it through a socket pair.
Where the system only has select(), which takes a few hundred sockets (Windows), further ones go to a further
monitor with a thread of its own, and so on.

What the socket has taken cannot be taken back one by one: when the network is away for half a minute, or the
subscriber stopped, the system delivers it afterwards, however old: velocities of half a minute ago. All of it
together can be thrown away, by resetting the connection. The monitor looks at each link twice a second
(`LOOK`), and says so when

* the oldest byte is older than `MOST_AGE`: what holds for everything small, velocities and states;
* or, with more than `BULK` bytes under way, when none of them arrived for that long: a subscriber that is
  behind a burst gets on as long as it reads;
* or, with large messages (a map, images), when none arrived and the other computer does not even acknowledge:
  a subscriber that works for long on each image is slow, not gone.
"""

from __future__ import annotations

import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

from rosproto.logs import get_logger
from rosproto.transport.tcp import open_selector, wake_pair
from rosproto.transport.unsent_bytes import UnsentBytes

_log = get_logger("rosproto.node")


LOOK = 0.5  # seconds between two looks: by so much an age may be overestimated, and so much later it is seen
MOST_AGE = 4.0  # seconds; with a look and the way to the subscriber this stays below five
BULK = 256 << 10  # bytes
_MOST_MARKS = 64


class Backlog:
    """What is on its way to one subscriber, from the look that first sees it until nothing is. No I/O here.

    Args:
        since: Seconds, of the last moment at which nothing was under way.
    """

    __slots__ = ("_acked", "_looked", "_marks", "_moved", "_since")

    def __init__(self, since: float) -> None:
        self._since = since  # the oldest byte was written after this
        self._moved = since  # when the last one arrived
        self._looked = since
        self._acked: int | None = None
        self._marks: deque[tuple[float, int]] = deque(maxlen=_MOST_MARKS)

    def look(self, now: float, written: int, queue: UnsentBytes, *, large: bool) -> str:
        """Whether it is too old.

        Args:
            now: Seconds.
            written: Bytes written so far, of which `queue` tells how many are not there yet.
            queue: What the system says.
            large: Large messages are among them.

        Returns:
            Why the connection should be reset; "" for no reason.
        """
        acked = written - queue.waiting
        if self._acked is None or acked > self._acked:
            if self._acked is not None:
                self._moved = now
            self._acked = acked
            while self._marks and self._marks[0][1] <= acked:
                self._since = self._marks.popleft()[0]
        self._marks.append((now, written))
        late, self._looked = now - self._looked > 2 * LOOK, now
        if late:  # this process did not get to run, and what it wrote just now looks old: the next look tells
            return ""
        age, still = now - self._since, now - self._moved
        if large:
            stale = queue.in_flight and still >= MOST_AGE
        elif queue.waiting > BULK:
            stale = still >= MOST_AGE
        else:
            stale = age >= MOST_AGE
        if not stale:
            return ""
        what = "its computer does not answer" if queue.in_flight else "it does not read"
        return f"{queue.waiting} bytes, the oldest {age:.1f} s old, have not arrived; {what}"


TICK = 0.001  # seconds until the end of a burst is sent at the latest, when this thread gets to run
IDLE_TICKS = 20  # after so many ticks without a batch the thread sleeps again
MOST_IN_SELECT = 500  # one thread's; Windows' select() takes 512 sockets
LONGEST_SLEEP = 5.0  # seconds; only so that no wait is without an end


class MonitoredLink(Protocol):
    """What the monitor asks of a link."""

    @property
    def sock(self) -> socket.socket: ...

    def on_readable(self) -> None: ...

    def on_writable(self) -> None: ...

    def flush(self) -> None: ...

    def look(self, now: float, before: float) -> None:
        """Look after what is on its way.

        Args:
            now: `time.monotonic()`.
            before: When the monitor looked before that.
        """


class LinkMonitor:
    """The thread; started with the first link, ended by `close`."""

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
        self._due: deque[MonitoredLink] = deque()
        self._ticking = False
        self._closing = False
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()
        self._further: LinkMonitor | None = None
        self._elsewhere: set[MonitoredLink] = set()  # what the further one watches
        self._looked = time.monotonic()

    # -- from any thread ------------------------------------------------------------------------------------

    def add(self, link: MonitoredLink) -> None:
        """Watch a link; its socket must not block."""
        self._request(lambda: self._watch(link, selectors.EVENT_READ))

    def want_write(self, link: MonitoredLink, wanted: bool) -> None:
        """Call `on_writable` as soon as the socket takes more, until told otherwise."""
        events = selectors.EVENT_READ | (selectors.EVENT_WRITE if wanted else 0)
        self._request(lambda: self._change(link, events))

    def remove(self, link: MonitoredLink) -> None:
        """Stop watching, then close the socket.

        The socket is closed here and not by the caller: a number re-used while the selector still knows it
        would watch somebody else's connection.
        """
        self._request(lambda: self._drop(link))

    def flush_later(self, link: MonitoredLink) -> None:
        """Call `link.flush()` about a millisecond from now."""
        self._due.append(link)
        if not self._ticking:
            self._ticking = True
            self._wake()

    def close(self, timeout: float = 2.0) -> None:
        """End the thread; links still watched have their sockets closed."""
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
            request()  # the thread is ending: nobody else uses the selector
        elif threading.current_thread() is not self._thread:
            self._wake()

    def _wake(self) -> None:
        try:
            self._wake_out.send(b"\0")
        except OSError:
            pass  # full: it is being woken already; closed: it is ending

    # -- in the thread --------------------------------------------------------------------------------------

    def _run(self) -> None:
        idle = 0
        while not self._closing:
            while self._requests:
                self._requests.popleft()()
            ready = self._selector.select(TICK if self._ticking else self._sleep())
            for key, events in ready:
                self._serve(key.data, events)
            idle = 0 if self._flush_due() else idle + 1
            self._look()
            if self._ticking and idle > IDLE_TICKS:
                self._ticking = False
                # A link may have come between the look and the note: it saw `_ticking` and did not wake us.
                self._ticking = bool(self._due)

    def _serve(self, link: MonitoredLink | None, events: int) -> None:
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

    def _sleep(self) -> float:
        """Until the next look; without a link nothing is to be looked at."""
        return LOOK if len(self._selector.get_map()) > 1 else LONGEST_SLEEP

    def _look(self) -> None:
        now, before = time.monotonic(), self._looked
        if now - before < LOOK:
            return
        self._looked = now
        for key in list(self._selector.get_map().values()):
            if key.data is not None:
                try:
                    key.data.look(now, before)
                except Exception:
                    _log.exception("! a link failed unexpectedly: %r", key.data)
                    self._drop(key.data)

    def _watch(self, link: MonitoredLink, events: int) -> None:
        selector = self._selector
        if isinstance(selector, selectors.SelectSelector) and len(selector.get_map()) > MOST_IN_SELECT:
            self._watch_elsewhere(link, events)
            return
        try:
            self._selector.register(link.sock, events, link)
        except (ValueError, KeyError, OSError) as error:
            _log.debug("! not watched, closed already: %r: %s", link, error)

    def _watch_elsewhere(self, link: MonitoredLink, events: int) -> None:
        if self._further is None:
            self._further = LinkMonitor(f"{self._name}+")
        self._elsewhere.add(link)
        self._further.add(link)
        if events & selectors.EVENT_WRITE:
            self._further.want_write(link, True)

    def _change(self, link: MonitoredLink, events: int) -> None:
        if link in self._elsewhere:
            assert self._further is not None
            self._further.want_write(link, bool(events & selectors.EVENT_WRITE))
            return
        try:
            self._selector.modify(link.sock, events, link)
        except KeyError:
            # Full before it was added, over a latched message. (One that was removed has a closed socket.)
            self._watch(link, events)
        except (ValueError, OSError):
            pass  # removed meanwhile

    def _drop(self, link: MonitoredLink) -> None:
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
