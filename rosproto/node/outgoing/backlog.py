"""How old the oldest byte is that was written to a subscriber and is not there yet, and when that is too old.

What the socket has taken cannot be taken back one by one: when the network is away for half a minute, or the
subscriber stopped, the system delivers it afterwards, however old: velocities of half a minute ago. All of it
together can be thrown away, by resetting the connection. The monitor looks at each link twice a second
(`LOOK`), and says so when

* the oldest byte is older than `MOST_AGE`: what holds for everything small, velocities and states;
* or, with more than `BULK` bytes under way, when none of them arrived for that long: a subscriber that is
  behind a burst gets on as long as it reads;
* or, with large messages (a map, images), when none arrived and the other computer does not even acknowledge:
  a subscriber that works for long on each image is slow, not gone.

No I/O here.
"""

from __future__ import annotations

from collections import deque

from rosproto.transport.send_queue import SendQueue

LOOK = 0.5  # seconds between two looks: by so much an age may be overestimated, and so much later it is seen
MOST_AGE = 4.0  # seconds; with a look and the way to the subscriber this stays below five
BULK = 256 << 10  # bytes
_MOST_MARKS = 64


class Backlog:
    """What is on its way to one subscriber, from the look that first sees it until nothing is.

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

    def look(self, now: float, written: int, queue: SendQueue, *, large: bool) -> str:
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
