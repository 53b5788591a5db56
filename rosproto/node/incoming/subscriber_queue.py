"""The queue and the callback of one subscriber, and the thread in which the callback runs.

An inbox holds at most `size` messages; the oldest is dropped and counted. Memory is bounded, and with
`size=1` the inbox holds the newest message.

Callbacks run in a thread of the library, one call at a time for each subscriber.

A quick callback runs in the thread that received the message, which saves waking another one (25 us per
message, measured). The connection is not read meanwhile, so a slow callback gets a separate thread, behind an
inbox of `queue_size` messages. That thread ends after `QUICK_CALLS` quick calls (the first time after
`QUICK_CALLS_AT_FIRST`), or when no message arrives for `IDLE_WAIT`.

Slowness is measured in real time, so on a busy computer a quick callback that was interrupted looks slow. Two
interruptions in a row are rare, since a thread that has just waited gets a whole time slice. So a single slow
call counts only if it took `SURELY_SLOW`; two in a row always count. A thread for a quick callback is costly:
it competes with the reader for the GIL, and messages are dropped meanwhile.

All exceptions of a callback are logged, also `SystemExit`, which would silently end only the link's thread.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from time import perf_counter, time
from typing import TypeVar

from rosproto.codec import Message
from rosproto.logs import get_logger
from rosproto.node.definitions.topic_type import TopicType
from rosproto.node.events import is_interrupt
from rosproto.node.stats import ConnectedLink
from rosproto.transport.deadline import wait_for

_log = get_logger("rosproto.node")
T = TypeVar("T")


class Inbox:
    """Bounded queue of (message, receive time), oldest dropped; filled by link threads.

    Attributes:
        lock, condition: Guard all state; `condition` uses `lock` (entering `lock` itself is twice as fast).
        size: Maximum number of waiting messages.
        received: Messages added so far.
        dropped: Messages dropped so far.
        latest: The newest message, taken or not; None before the first.
        closed: True once no more messages are accepted.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.received = 0
        self.dropped = 0
        self.latest: Message | None = None
        self.lock = threading.Lock()
        self.condition = threading.Condition(self.lock)
        self._queue: deque[tuple[Message, float]] = deque()
        self._waiters = 0
        self.closed = False

    def abandon(self) -> None:
        """Close in a fork of this process, with new locks: the parent may have held the old ones."""
        self.lock = threading.Lock()
        self.condition = threading.Condition(self.lock)
        self.close()

    def put(self, batch: Sequence[Message], stamp: float) -> None:
        """Add messages, the newest last."""
        with self.lock:
            self.put_locked(batch, stamp)

    def put_locked(self, batch: Sequence[Message], stamp: float, *, older: bool = False) -> None:
        """As `put`, for a caller that holds `lock`; with `older` they go before the waiting messages."""
        if self.closed:
            return
        queue = self._queue
        if older:
            queue.extendleft((message, stamp) for message in reversed(batch))
        else:
            self.received += len(batch)
            self.latest = batch[-1]
            if len(batch) > self.size:
                self.dropped += len(batch) - self.size
                batch = batch[-self.size :]
            queue.extend([(message, stamp) for message in batch])
        while len(queue) > self.size:
            queue.popleft()
            self.dropped += 1
        if self._waiters:
            self.condition.notify_all()

    def count(self, batch: Sequence[Message]) -> None:
        """Count messages that go to a callback directly; for a caller that holds `lock`."""
        self.received += len(batch)
        self.latest = batch[-1]

    def get(self, timeout: float | None) -> tuple[Message, float] | None:
        """Take the oldest message; None after the time-out, or if the inbox is closed and empty."""
        with self.condition:
            if not self._queue and not self.closed:
                self._waiters += 1
                try:
                    wait_for(self.condition, lambda: self._queue or self.closed, timeout)
                finally:
                    self._waiters -= 1
            return self._queue.popleft() if self._queue else None

    def get_some(self, timeout: float | None, limit: int) -> list[Message]:
        """As `get`, for up to `limit` messages, without their times of receipt."""
        first = self.get(timeout)
        if first is None or limit == 1:
            return [] if first is None else [first[0]]
        with self.lock:
            queue = self._queue
            return [first[0], *(queue.popleft()[0] for _ in range(min(limit - 1, len(queue))))]

    def close(self) -> None:
        """Accept no more messages, drop those that wait, and wake all waiting threads."""
        with self.condition:
            self.closed = True
            self.dropped += len(self._queue)
            self._queue.clear()
            self.condition.notify_all()

    def __len__(self) -> int:
        return len(self._queue)


SLOW_CALL = 0.002  # seconds for one call, or for `CHUNK` messages received at once
SURELY_SLOW = 0.050  # seconds: longer than a time slice of other programs
QUICK_CALLS = 100
QUICK_CALLS_AT_FIRST = 5
CHUNK = 8  # messages between two readings of the clock, within a batch
MAX_AT_ONCE = 64  # messages that the callback's thread takes at once
IDLE_WAIT = 5.0


class _Caller:
    """What both ways to call a callback need."""

    def __init__(self, callback: Callable[[Message], object], inbox: Inbox, topic: str) -> None:
        self._callback = callback
        self._inbox = inbox
        self._topic = topic

    def _log_error(self) -> None:
        _log.exception("! %s: the callback %r raised; the subscriber continues", self._topic, self._callback)


class CallbackRunner(_Caller):
    """Calls one callback, in the receiving thread or, while it is slow, behind an inbox."""

    def __init__(self, callback: Callable[[Message], object], inbox: Inbox, topic: str) -> None:
        super().__init__(callback, inbox, topic)
        self._running = False
        self._suspect = False  # the last call took long
        self._slow_times = 0
        self._thread: threading.Thread | None = None

    @property
    def takes_all(self) -> bool:
        """True while the callback gets all messages of each read."""
        return self._thread is None

    def offer(self, batch: Sequence[Message], stamp: float) -> None:
        """Call the callback with each message, now or soon; called by link threads."""
        inbox = self._inbox
        with inbox.lock:
            if inbox.closed:
                return
            if self._running or self._thread is not None:
                inbox.put_locked(batch, stamp)
                if self._thread is None:
                    self._start_thread()  # another link's thread is in the callback
                return
            self._running = True
            inbox.count(batch)
        done = self._call_some(batch)
        if done == len(batch):
            self._done()
        else:
            self._too_slow(batch[done:] if done >= 0 else (), stamp)

    def begin(self, batch: Sequence[Message], stamp: float) -> None:
        """Call the callback with these messages, in a separate thread."""
        with self._inbox.lock:
            self._inbox.put_locked(batch, stamp)
            self._start_thread()

    def offer_one(self, message: Message) -> None:
        """As `offer`, for a single message; kept short, since nearly all messages take this path."""
        inbox = self._inbox
        with inbox.lock:
            if free := not (self._running or self._thread is not None or inbox.closed):
                self._running = True
                inbox.received += 1
                inbox.latest = message
        if not free:
            self.offer((message,), time())
            return
        began = perf_counter()
        try:
            self._callback(message)
        except BaseException:
            self._log_error()
        took = perf_counter() - began
        if took < SLOW_CALL:
            self._suspect = False
        elif self._is_slow(took):
            self._too_slow((), 0.0)
            return
        self._running = False  # as `_done`, without the call
        if self._thread is not None:
            self._done()

    def _done(self) -> None:
        """Finish quick calls."""
        # This order replaces a lock: a thread started meanwhile sees False here, or we see the thread.
        self._running = False
        if self._thread is not None:
            with self._inbox.lock:
                self._inbox.condition.notify_all()

    def _too_slow(self, rest: Sequence[Message], stamp: float) -> None:
        """Finish slow calls; pass the rest of the batch, and later messages, to a thread."""
        inbox = self._inbox
        with inbox.lock:
            self._running = False
            self._slow_times += 1
            inbox.put_locked(rest, stamp, older=True)
            if self._thread is None and not inbox.closed:
                self._start_thread()
            inbox.condition.notify_all()

    def _is_slow(self, took: float) -> bool:
        """True if a call, or `CHUNK` calls, of more than `SLOW_CALL` proves that the callback is slow."""
        proven = self._suspect or took >= SURELY_SLOW
        self._suspect = not proven
        return proven

    def _call_some(self, batch: Sequence[Message]) -> int:
        """Call with each message until slow; return the number of calls, -1 if the last ones were slow."""
        callback, inbox = self._callback, self._inbox
        last = perf_counter()
        for start in range(0, len(batch), CHUNK):
            for message in batch[start : start + CHUNK]:
                if inbox.closed:
                    return len(batch)
                try:
                    callback(message)
                except BaseException:
                    self._log_error()
            now = perf_counter()
            took, last = now - last, now
            if took < SLOW_CALL:
                self._suspect = False
            elif self._is_slow(took):
                done = min(start + CHUNK, len(batch))
                return done if done < len(batch) else -1
        return len(batch)

    def _call(self, message: Message) -> None:
        if self._inbox.closed:
            return
        try:
            self._callback(message)
        except BaseException:
            self._log_error()

    def _start_thread(self) -> None:
        self._thread = threading.Thread(
            target=self._run, name=f"rosproto:callback {self._topic}", daemon=True
        )
        self._thread.start()

    def _run(self) -> None:
        """Call with waiting messages until the callback has been quick for a while, or the inbox closes."""
        inbox = self._inbox
        quick, idle, share = 0, False, 1
        enough = QUICK_CALLS if self._slow_times > 1 else QUICK_CALLS_AT_FIRST
        while True:
            with inbox.condition:
                # The link's thread may still be in the slow call that started this thread: never two at once.
                inbox.condition.wait_for(lambda: not self._running or inbox.closed, IDLE_WAIT)
                if inbox.closed or ((idle or quick > enough) and not len(inbox)):
                    self._thread = None
                    return
                if self._running:
                    continue
            # A slow callback should get new messages, so they wait in the inbox, which drops the oldest.
            messages = inbox.get_some(IDLE_WAIT, share)
            idle = not messages
            began = perf_counter()
            for message in messages:
                self._call(message)
            if perf_counter() - began < SLOW_CALL:
                quick, share = quick + len(messages), min(2 * share, MAX_AT_ONCE)
            else:
                quick, share = 0, 1


class InlineCaller(_Caller):
    """Calls the callback in the thread that received the message, however long it takes.

    The connection is not read meanwhile, so a slow callback fills the publisher's queue; only the last
    `queue_size` messages of each read are used. As in rospy, on which programs rely, the messages of one
    publisher arrive in order in one thread; those of two publishers may arrive at the same time.
    """

    takes_all = False

    def offer(self, batch: Sequence[Message], stamp: float) -> None:
        """Call with each of the last `queue_size` messages; called by link threads."""
        inbox = self._inbox
        with inbox.condition:
            open_ = not inbox.closed
            if open_:
                inbox.count(batch)
                inbox.dropped += max(0, len(batch) - inbox.size)
        for message in batch[-inbox.size :] if open_ else ():
            if inbox.closed:
                return
            try:
                self._callback(message)
            except BaseException:
                self._log_error()

    def begin(self, batch: Sequence[Message], stamp: float) -> None:
        """Call the callback with these messages, in a separate thread."""
        name = f"rosproto:callback {self._topic}"
        threading.Thread(target=self.offer, args=(batch, stamp), name=name, daemon=True).start()

    def offer_one(self, message: Message) -> None:
        """As `offer`, for one message."""
        inbox = self._inbox
        with inbox.lock:
            if inbox.closed:
                return
            inbox.received += 1
            inbox.latest = message
        try:
            self._callback(message)
        except BaseException:
            self._log_error()


class SubscriberQueue:
    """Takes messages and errors from links, for one `Subscriber`.

    Args:
        topic: Resolved name.
        type_: The requested type.
        callback: Called with each message; if None, messages wait in `inbox`.
        queue_size: Maximum number of waiting messages.
        raw: Deliver `AnyMsg` with the encoded bytes.
        on_error: Called with each error of a link.
        on_links: Called with the connected links when they change.
        inline: Call back in the thread that received the message, however long it takes.
        renew: Called after a change of `queue_size`, to renew the subscription's delivery.

    Attributes:
        inbox: Messages that are not taken yet.
        runner: Calls the callback; None without one.
        offer: `(messages, receive time)`: takes messages from a link.
        offer_one: The same for one message, if there is a callback; else None.
    """

    offer: Callable[[Sequence[Message], float], None]
    offer_one: Callable[[Message], None] | None

    def __init__(
        self,
        topic: str,
        type_: TopicType,
        *,
        callback: Callable[[Message], object] | None = None,
        queue_size: int,
        raw: bool = False,
        on_error: Callable[[Exception], object] | None = None,
        on_links: Callable[[frozenset[ConnectedLink]], object] | None = None,
        inline: bool = False,
        renew: Callable[[], None],
    ) -> None:
        self.topic = topic
        self.type = type_
        self.raw = raw
        self.inbox = Inbox(queue_size)
        self.runner: CallbackRunner | InlineCaller | None = None
        if callback:
            kind = InlineCaller if inline else CallbackRunner
            self.runner = kind(callback, self.inbox, topic)
        self._on_error = on_error
        self._on_links = on_links
        self._renew = renew
        self.offer = self.inbox.put
        self.offer_one = None
        if self.runner is not None:
            self.offer, self.offer_one = self.runner.offer, self.runner.offer_one

    def hand_over(self, messages: Sequence[Message], stamp: float) -> None:
        """Take latched messages; the callback is called in another thread than the subscribing one."""
        if self.runner is None:
            self.offer(messages, stamp)
        else:
            self.runner.begin(messages, stamp)

    @property
    def keeps(self) -> int | None:
        """Most messages of one read that are delivered; None for all (to a quick callback)."""
        return None if self.runner is not None and self.runner.takes_all else self.inbox.size

    @property
    def queue_size(self) -> int:
        """Maximum number of messages that wait for the program; may be changed."""
        return self.inbox.size

    @queue_size.setter
    def queue_size(self, size: int) -> None:
        self.inbox.size = size
        self._renew()

    def report(self, error: Exception) -> None:
        """Call `on_error` with the error of a link."""
        self._tell(self._on_error, error)

    def note_links(self, links: frozenset[ConnectedLink]) -> None:
        """Call `on_links` with the connected links."""
        self._tell(self._on_links, links)

    def _tell(self, callback: Callable[[T], object] | None, news: T) -> None:
        if callback is not None:
            try:
                callback(news)
            except BaseException as problem:  # as from a callback
                if is_interrupt(problem):
                    raise
                _log.exception("! %s: %r raised", self.topic, callback)

    def end(self) -> None:
        """Accept no more messages; wake all waiting threads."""
        self.inbox.close()

    def abandon(self) -> None:
        """End in a fork of this process; see `Inbox.abandon`."""
        self.inbox.abandon()
