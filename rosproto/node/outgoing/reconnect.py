"""Make a subscriber connect again after its connection was reset because the backlog was too old.

Two problems keep subscribers of other libraries from reconnecting. The reset may have been lost, and then
the subscriber keeps its half of the connection (rospy and roscpp: until the keep-alive after a minute). And
rospy does not reconnect to a publisher that ended the connection until the master announces it again.

So, once a second, we try to connect with the same local and remote address. A system that still has the other
half acknowledges it, ours answers with a reset, and the subscriber sees the end: the recovery from half-open
connections in RFC 9293, 3.5.1. A system without it refuses. Then we repeatedly register the topic, which
makes the master send publisherUpdate to all subscribers, until the subscriber is back.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from dataclasses import dataclass

from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.transport.backoff import Backoff
from rosproto.transport.deadline import Deadline

_log = get_logger("rosproto.node")

GIVE_UP_SECONDS = 300.0
RETRY_SECONDS = 1.0  # between two attempts
SETTLE_SECONDS = 0.2  # in which most subscribers reconnect by themselves
MAX_THREADS = 32  # threads at a time in this process; further subscribers reconnect after their keep-alive

_places = threading.BoundedSemaphore(MAX_THREADS)


@dataclass(frozen=True)
class SubscriberReconnect:
    """The thread that brings one subscriber back.

    Attributes:
        closing: Set when the node closes.
        caller_id: The subscriber's node name.
        bind: Binds a socket to our address of the former connection.
        remote: The subscriber's address of it.
        announce: Registers the topic again.
        is_back: Whether the subscriber is connected again.
    """

    closing: threading.Event
    caller_id: str
    bind: Callable[[socket.socket], None]
    remote: tuple[str, int]
    announce: Callable[[], None]
    is_back: Callable[[], bool]

    def start(self) -> None:
        """Start the thread, unless there are too many."""
        if _places.acquire(blocking=False):
            threading.Thread(target=self._run, name=f"rosproto:lost {self.caller_id}", daemon=True).start()

    def _run(self) -> None:
        try:
            self.bring_back(Deadline(GIVE_UP_SECONDS))
        finally:
            _places.release()

    def bring_back(self, deadline: Deadline) -> None:
        """Repeat `knock` and `announce` until the subscriber is back, the node closes, or time is up."""
        while not self._is_done(deadline) and not self.knock():
            pass
        self.closing.wait(SETTLE_SECONDS)
        pauses = Backoff(first=1.0, factor=2.0, maximum=5.0, jitter=0.1)
        while not self._is_done(deadline):
            try:
                self.announce()
            except RosError as error:
                _log.debug("! cannot be announced again to %s: %s", self.caller_id, error)
            self.closing.wait(pauses.next())

    def _is_done(self, deadline: Deadline) -> bool:
        return deadline.expired or self.closing.is_set() or self.is_back()

    def knock(self) -> bool:
        """Try to connect once; True if the other half is gone, or this cannot be tried."""
        with socket.socket(socket.AF_INET6 if ":" in self.remote[0] else socket.AF_INET) as sock:
            try:
                self.bind(sock)
            except OSError as error:
                _log.debug("! the end of the connection to %s cannot be reported: %s", self.caller_id, error)
                return True
            sock.settimeout(RETRY_SECONDS)
            try:
                sock.connect(self.remote)
            except ConnectionRefusedError:
                return True
            except TimeoutError:
                return False
            except OSError:  # no route at present, or our own half is still being closed
                self.closing.wait(RETRY_SECONDS)
                return False
            return True
