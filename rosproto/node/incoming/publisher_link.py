"""Base class of a subscriber's link to one publisher: it connects, receives and retries.

Each session, and each try to begin one, has a thread, except those of `LocalLink`; a link that waits for its
next try has none. The states are in `publisher_link_state.py`. The subclasses `TcprosLink`, `UdprosLink` and
`LocalLink` (for a publisher in this process) open a session and receive.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from time import monotonic
from typing import TYPE_CHECKING

from rosproto.errors import (
    CodecError,
    ConnectionLost,
    DefinitionError,
    MasterError,
    Md5sumMismatch,
    RosError,
    RosTimeout,
    TooLarge,
)
from rosproto.logs import get_logger
from rosproto.node.definitions.md5sum_mismatch import RevisedType
from rosproto.node.events import Event, EventKind, without_frames
from rosproto.node.incoming.publisher_link_state import (
    MIN_WAIT_SECONDS,
    STEADY_SECONDS,
    LinkEvent,
    LinkState,
    RetryPauses,
    next_state,
)
from rosproto.node.stats import ConnectedLink, LinkStats
from rosproto.protocol.handshake import HandshakeRefused
from rosproto.transport.os_errors import interpreter_shuts_down, is_refused, translate
from rosproto.transport.shared_threads import shared_threads

if TYPE_CHECKING:
    from rosproto.node.incoming.subscription import Subscription

_log = get_logger("rosproto.node")

REFUSALS = (HandshakeRefused, Md5sumMismatch, DefinitionError, CodecError, TooLarge)
"""Errors after which an immediate retry is useless."""


def is_gone(error: BaseException | None) -> bool:
    """Whether the publisher's computer or node answered that it is not there: it has ended."""
    return isinstance(error, MasterError) or (error is not None and is_refused(error))


ASK_EVERY, ASK_AFTER_SECONDS = 4, 1.0
"""Failed tries, or a wait, after which the master is asked whether it still lists the publisher."""


class PublisherLink:
    """States of a link; subclasses implement the session in `_open` and `_receive`.

    Attributes:
        uri: XML-RPC URI of the publisher, as the master gave it.
        id: Number of the connection in getBusInfo.
        state: See `publisher_link_state.py`; only `_step` changes it.
        header: The publisher's connection header; empty while there is none.
        caller_id: The publisher's node name; "" while unknown.
        address: "host:port" of the connection; the URI while there is none.
        last_error: The error that ended the last session or try; None after a success.
        named: False if the master does not list the publisher; the link is then kept while it is connected.
    """

    transport = "TCPROS"

    def __init__(self, subscription: Subscription, uri: str, id: int) -> None:
        self.subscription = subscription
        self.topic = subscription.name
        self.uri = uri
        self.id = id
        self.header: dict[str, str] = {}
        self.caller_id = ""
        self.address = uri
        self._context = subscription.context
        self.named = True
        self.state = LinkState.WAITING
        self._condition = threading.Condition()
        self._nudged = False
        self._pauses = RetryPauses()
        self._waited = 0.0  # the present or last wait, in seconds
        self._may_retry = 0.0  # monotonic time before which not even a nudge ends the wait
        self._retry: Future[None] | None = None  # None while a thread is at work
        self._sessions = 0
        self._session = 0
        self._attempts = 0
        self._begun_at: float | None = None
        self._logged: type | None = None  # kind of the last failure that was logged
        self._revised: RevisedType | None = None
        self.last_error: Exception | None = None
        self._bytes = 0
        self._messages = 0
        self._worker = 0  # the thread that is at work
        self._started = False
        self._ended = threading.Event()

    def start(self) -> None:
        """Begin the first try."""
        self._begin(LinkEvent.DUE)
        self._started = True

    @property
    def connected(self) -> bool:
        """True while messages can arrive."""
        return self.state is LinkState.RECEIVING

    @property
    def connection(self) -> ConnectedLink:
        """The present connection."""
        return ConnectedLink(self.caller_id, self.address, self._session)

    @property
    def closed(self) -> bool:
        """True once the link is closed."""
        return self.state is LinkState.CLOSED

    @property
    def skipped(self) -> int:
        """Messages of the present session that were not decoded, since no subscriber keeps that many."""
        return 0

    def nudge(self) -> None:
        """Retry at once: the master named the publisher again, so it may have been restarted.

        Ends the current wait, or else the next one.
        """
        with self._condition:
            if not self.state.is_wait:
                self._step(LinkEvent.NUDGED)
            was, self._nudged = self._nudged, True
            if self._retry is not None and not was:
                self._retry_in(self._may_retry - monotonic())

    def close(self) -> None:
        """End the link for good; does not wait for the thread (`join` does)."""
        with self._condition:
            self._step(LinkEvent.WITHDRAWN)
            retry, self._retry = self._retry, None
        if retry is not None:
            retry.cancel()
            self._end()
        self._interrupt()

    def _end(self) -> None:
        """The link is closed, and no thread is at work."""
        self.subscription.link_closed(self)
        self._ended.set()

    def interrupt(self) -> None:
        """End the present session; the link begins a new one at once."""
        self.nudge()
        self._interrupt()

    def join(self, timeout: float) -> None:
        """Wait for the thread at work, unless called in it (by a callback that closes its own subscriber)."""
        if self._started and self._worker != threading.get_ident():
            self._ended.wait(timeout)

    # -- the threads ----------------------------------------------------------------------------------------

    def _begin(self, event: LinkEvent) -> None:
        """Begin a try in a thread of its own."""
        name = f"rosproto:{self.topic} < {self.uri}"
        threading.Thread(target=self._run, args=(event,), name=name, daemon=True).start()

    def _run(self, event: LinkEvent) -> None:
        if self._step(event) is LinkState.REQUESTING:
            self._work(self._hold_session)
        else:
            self._wait()

    def _hold_session(self) -> bool:
        """Begin a session and receive."""
        if self._begin_session():
            self._receive()
        return False

    def _begin_session(self) -> bool:
        """Open a session; False if the link was closed meanwhile."""
        self._open()
        self._session = self._context.next_link_id()  # before anybody sees it as connected
        if self._step(LinkEvent.ACCEPTED) is not LinkState.RECEIVING:
            return False
        self._begun_at = monotonic()
        self._begun()
        return True

    def _work(self, part: Callable[[], bool]) -> bool:
        """Do a part of a session; unless it returns that the session goes on, end it and wait to retry."""
        self._worker = threading.get_ident()
        goes_on = over = False
        try:
            goes_on = part()
        except (RosError, OSError) as error:
            self._failed(error)
        except Exception as error:
            over = interpreter_shuts_down(error)
            if not over:
                _log.exception("! %s: the link to %s failed unexpectedly", self.topic, self.uri)
                self._failed(error)
        finally:
            if not goes_on:
                self._end_session()
        self._worker = 0
        if not (goes_on or over):
            if not self.named:
                self.close()
            self._wait()
        return goes_on

    def _step(self, event: LinkEvent) -> LinkState:
        """Enter the next state of the table; only this method changes the state."""
        with self._condition:
            self.state = next_state(self.state, event)
            return self.state

    @property
    def _lasted(self) -> float | None:
        """Seconds since the session began; None without a session."""
        return None if self._begun_at is None else monotonic() - self._begun_at

    def _wait(self) -> None:
        """Wait for the next try, without a thread if possible."""
        self._waited = self._pauses.after(
            self._lasted,
            refused=self.state is LinkState.REFUSED,
            mismatch=isinstance(self.last_error, Md5sumMismatch),
            gone=is_gone(self.last_error),
        )
        self._begun_at = None
        # Any node can cause any number of nudges, so the wait has a minimum.
        shortest = min(self._waited, MIN_WAIT_SECONDS)
        while True:
            with self._condition:
                if self.state is LinkState.CLOSED:
                    break
                self._may_retry = monotonic() + shortest
                try:
                    self._retry_in(shortest if self._nudged else self._waited)
                    return
                except RuntimeError as error:
                    if interpreter_shuts_down(error):
                        return
                    self._condition.wait(MIN_WAIT_SECONDS)  # the process has no thread left
        self._end()

    def _retry_in(self, seconds: float) -> None:
        before, self._retry = self._retry, shared_threads().add_later(seconds, self._due)
        if before is not None:
            before.cancel()

    def _due(self) -> None:
        """The wait is over."""
        with self._condition:
            if self._retry is None:
                return  # closed
            nudged, self._nudged = self._nudged, False
            event = LinkEvent.NUDGED if nudged else LinkEvent.DUE
            try:
                self._begin(event)
            except RuntimeError as error:
                if not interpreter_shuts_down(error):
                    self._retry_in(MIN_WAIT_SECONDS)  # the process has no thread left
                return
            self._retry = None

    def _begun(self) -> None:
        self._sessions += 1
        self._attempts = 0
        self.last_error = None
        _log.debug("= %s: connected to %s at %s", self.topic, self.caller_id, self.address)
        self.subscription.link_changed()
        self._context.events.emit(
            Event(EventKind.CONNECTED, self.topic, self.address, peer=self.caller_id, direction="in")
        )

    def _failed(self, error: Exception) -> None:
        """Record the error; log and report it once, not after every try."""
        if isinstance(error, OSError) and not isinstance(error, RosError):
            error = translate(error, f"{self.topic} from {self.address}", self.address)
        error = without_frames(error)
        was = self.state
        refused = isinstance(error, REFUSALS)
        if self._step(LinkEvent.REFUSED if refused else LinkEvent.FAILED) is LinkState.CLOSED:
            return
        if was is LinkState.RECEIVING:
            self.subscription.link_changed()
        self._attempts += 1
        slow = self._waited > ASK_AFTER_SECONDS
        if slow or self._attempts % ASK_EVERY == 0:
            self._context.check_publishers(self.subscription, not slow)
        if was is LinkState.RECEIVING:
            kind = EventKind.DISCONNECTED
        else:
            kind = EventKind.REFUSED if refused else EventKind.FAILED
        news = self.last_error is None or type(self.last_error) is not type(error)
        self.last_error = error
        if news:
            self._log_failure(error)
            self.subscription.report(error)
            self._context.events.emit(
                Event(kind, self.topic, self.address, error, peer=self.caller_id, direction="in")
            )

    def _log_failure(self, error: Exception) -> None:
        """Log an error once for each kind, until a session has lasted `STEADY_SECONDS`."""
        if (self._lasted or 0.0) >= STEADY_SECONDS:
            self._logged = None
        if isinstance(error, (ConnectionLost, MasterError, RosTimeout)) and not isinstance(error, REFUSALS):
            # It is unreachable or closed: no warning, since the master reports it soon.
            _log.debug("! %s: publisher %s: %s", self.topic, self.caller_id or self.uri, error)
        elif self._logged is not type(error):
            self._logged = type(error)
            text = "! %s: publisher %s: %s"
            self._context.peer_log.warning(self.topic, text, self.topic, self.caller_id or self.uri, error)

    def _end_session(self) -> None:
        self.header = {}
        self.address = self.uri
        revised, self._revised = self._revised, None
        if revised is not None:
            self.subscription.forget_revised(revised)

    # -- the session, for subclasses ------------------------------------------------------------------------

    def _open(self) -> None:
        """Connect and exchange headers; set `header`, `caller_id`, `address`. Raises RosError, OSError."""
        raise NotImplementedError

    def _receive(self) -> None:
        """Receive until the session ends; always raises."""
        raise NotImplementedError

    def _interrupt(self) -> None:
        """Wake the thread when it waits inside `_open` or `_receive`."""
        raise NotImplementedError

    def _counters(self) -> tuple[int, int]:
        """(bytes, messages) of all sessions."""
        return self._bytes, self._messages

    def stats(self) -> LinkStats:
        """Counters over all sessions."""
        count, messages = self._counters()
        return LinkStats(
            topic=self.topic,
            direction="in",
            peer=self.caller_id,
            address=self.address,
            transport=self.transport,
            connected=self.connected,
            bytes=count,
            messages=messages,
            reconnects=max(0, self._sessions - 1),
            state=self.state.value,
            last_error=str(self.last_error or ""),
        )

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.topic} <- {self.caller_id or self.uri}, {self.state.value}>"
