"""Bringing back a subscriber that was cut off: what was on its way to it had become too old.

Two things keep a subscriber of another kind away. The reset may have been lost with everything else, and then
its half of the connection waits for ever (rospy and roscpp: until their keep-alive after a minute). And rospy
does not connect again to a publisher that ended the connection, as long as the master does not name it anew.

So, once a second, we ask for a connection from the same address to the same address. A system that still has
the other half answers with what it knows of it, ours resets that, and its program hears of the end: the
recovery from half-open connections in RFC 9293, 3.5.1. One that has it no more refuses. From then on we
register the topic at the master again, now and then, which has the master tell all subscribers who publishes
it, until that one is back.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable

from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.transport.backoff import Backoff
from rosproto.transport.deadline import Deadline

_log = get_logger("rosproto.node")

GIVE_UP = 300.0  # seconds
KNOCK = 1.0  # seconds between two
SETTLE = 0.2  # seconds in which most come back by themselves
MOST = 32  # threads at a time in this process; who is not among them comes back by its own keep-alive

_places = threading.BoundedSemaphore(MOST)


class SubscriberReconnect:
    """The thread that brings one subscriber back.

    Args:
        closing: Set when the node closes.
        caller_id: The subscriber's node name.
        bind: Binds a socket to our end of the connection that was.
        remote: Its end.
        announce: Registers the topic again.
        is_back: Whether nothing is left to do.
    """

    def __init__(
        self,
        closing: threading.Event,
        caller_id: str,
        *,
        bind: Callable[[socket.socket], None],
        remote: tuple[str, int],
        announce: Callable[[], None],
        is_back: Callable[[], bool],
    ) -> None:
        self._closing = closing
        self._caller_id = caller_id
        self._bind = bind
        self._remote = remote
        self._announce = announce
        self._is_back = is_back

    def start(self) -> None:
        """Begin, in a thread of its own, when there are not too many."""
        if _places.acquire(blocking=False):
            threading.Thread(target=self._run, name=f"rosproto:lost {self._caller_id}", daemon=True).start()

    def _run(self) -> None:
        try:
            self.bring_back(Deadline(GIVE_UP))
        finally:
            _places.release()

    def bring_back(self, deadline: Deadline) -> None:
        """Knock and announce until it is back, the node closes, or the time is over."""
        while not self._is_done(deadline) and not self.knock():
            pass
        self._closing.wait(SETTLE)
        pauses = Backoff(first=1.0, factor=2.0, most=5.0, jitter=0.1)
        while not self._is_done(deadline):
            try:
                self._announce()
            except RosError as error:
                _log.debug("! not announced again to %s: %s", self._caller_id, error)
            self._closing.wait(pauses.next())

    def _is_done(self, deadline: Deadline) -> bool:
        return deadline.expired or self._closing.is_set() or self._is_back()

    def knock(self) -> bool:
        """Ask once; True when the other half is known to be gone, or cannot be asked for."""
        with socket.socket(socket.AF_INET6 if ":" in self._remote[0] else socket.AF_INET) as sock:
            try:
                self._bind(sock)
            except OSError as error:
                _log.debug("! the end of the connection to %s is not told: %s", self._caller_id, error)
                return True
            sock.settimeout(KNOCK)
            try:
                sock.connect(self._remote)
            except ConnectionRefusedError:
                return True
            except TimeoutError:
                return False
            except OSError:  # no way there at present; or our own half is still being closed
                self._closing.wait(KNOCK)
                return False
            return True
