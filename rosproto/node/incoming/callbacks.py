"""Calls a subscriber's callback: at once in the link's thread, or in a thread of its own when it is slow.

Which thread calls: one of the library's. Never two at once for one subscriber.

A quick callback runs in the thread that received the message: no hand-over, no wake-up of another thread
(25 us less per message, measured). But while it runs, nobody reads the connection. So a slow
callback gets a thread of its own, behind an inbox of `queue_size` messages where the oldest is dropped: the
connection is read on, and the callback sees new messages. After `QUICK_CALLS` quick calls it goes back, after
a first time already when a few were quick, and whenever nothing comes for `IDLE_WAIT`.

What is slow is judged by the clock, and on a busy computer the clock goes on while the program does not: a
quick callback that was interrupted looks slow. It seldom is interrupted twice in a row, since who has just
waited has a whole turn of the processor before it. So one call that took long proves nothing unless it took
`SURELY_SLOW`; two in a row do. A thread for a quick callback is costly: it and the reader then fight for the
interpreter, and messages are dropped meanwhile.

Whatever a callback raises is logged, `SystemExit` of a `sys.exit()` too: in a thread it would end nothing but
the link, without a word.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from time import perf_counter, time
from typing import Any

from rosproto.logs import get_logger
from rosproto.node.incoming.inbox import Inbox

_log = get_logger("rosproto.node")

SLOW_CALL = 0.002  # seconds for one call, or for `CHUNK` messages received at once
SURELY_SLOW = 0.050  # seconds: longer than a turn of other programs at the processor
QUICK_CALLS = 100
QUICK_CALLS_AT_FIRST = 5
CHUNK = 8  # messages between two looks at the clock, when many came at once
MOST_AT_ONCE = 64  # messages that the callback's thread takes over in one piece
IDLE_WAIT = 5.0


class CallbackRunner:
    """One callback and the inbox before it."""

    def __init__(self, callback: Callable[[Any], object], inbox: Inbox, topic: str) -> None:
        self._callback = callback
        self._inbox = inbox
        self._topic = topic
        self._running = False
        self._suspect = False  # the last call took long
        self._slow_times = 0
        self._thread: threading.Thread | None = None

    @property
    def has_thread(self) -> bool:
        """True while the callback is found slow."""
        return self._thread is not None

    @property
    def takes_all(self) -> bool:
        """True while it sees every message, however many one read brings."""
        return self._thread is None

    def offer(self, batch: Sequence[Any], stamp: float) -> None:
        """Have the callback called with each message, now or soon; called by link threads."""
        inbox = self._inbox
        with inbox.lock:
            if inbox.closed:
                return
            if self._running or self._thread is not None:
                inbox.put_locked(batch, stamp)
                if self._thread is None:
                    self._start_thread()  # another link's thread is in the callback: this one reads on
                return
            self._running = True
            inbox.count(batch)
        done = self._call_some(batch)
        if done == len(batch):
            self._done()
        else:
            self._too_slow(batch[done:] if done >= 0 else (), stamp)

    def begin(self, batch: Sequence[Any], stamp: float) -> None:
        """Have the callback called with these first, in its own thread."""
        with self._inbox.lock:
            self._inbox.put_locked(batch, stamp)
            self._start_thread()

    def offer_one(self, message: Any) -> None:
        """As `offer`, for the one message that most reads bring: the way of nearly every one, kept short."""
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
        """The calls are over, and were quick."""
        # No lock, but this order: a thread begun meanwhile sees that we are done, or we see the thread.
        self._running = False
        if self._thread is not None:
            with self._inbox.lock:
                self._inbox.condition.notify_all()

    def _too_slow(self, rest: Sequence[Any], stamp: float) -> None:
        """The calls are over; what is left of the batch, and all that comes, goes through a thread."""
        inbox = self._inbox
        with inbox.lock:
            self._running = False
            self._slow_times += 1
            inbox.put_locked(rest, stamp, older=True)
            if self._thread is None and not inbox.closed:
                self._start_thread()
            inbox.condition.notify_all()

    def _is_slow(self, took: float) -> bool:
        """Whether a call, or a few together, that took longer than `SLOW_CALL` proves the callback slow."""
        proven = self._suspect or took >= SURELY_SLOW
        self._suspect = not proven
        return proven

    def _call_some(self, batch: Sequence[Any]) -> int:
        """Call with each; returns how many were called when it was found slow, -1: all, and slow."""
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

    def _call(self, message: Any) -> None:
        if self._inbox.closed:
            return
        try:
            self._callback(message)
        except BaseException:
            self._log_error()

    def _log_error(self) -> None:
        _log.exception("! %s: the callback %r raised; the subscriber goes on", self._topic, self._callback)

    def _start_thread(self) -> None:
        self._thread = threading.Thread(
            target=self._run, name=f"rosproto:callback {self._topic}", daemon=True
        )
        self._thread.start()

    def _run(self) -> None:
        """Call with what waits until the callback has been quick for a while, or the inbox is closed."""
        inbox = self._inbox
        quick, idle, share = 0, False, 1
        enough = QUICK_CALLS if self._slow_times > 1 else QUICK_CALLS_AT_FIRST
        while True:
            with inbox.condition:
                # The link's thread may still be in the slow call that made this thread: never two at once.
                inbox.condition.wait_for(lambda: not self._running or inbox.closed, IDLE_WAIT)
                if inbox.closed or ((idle or quick > enough) and not len(inbox)):
                    self._thread = None
                    return
                if self._running:
                    continue
            # Of a slow callback's messages the newest are wanted, so they wait in the inbox, not here.
            messages = inbox.get_some(IDLE_WAIT, share)
            idle = not messages
            began = perf_counter()
            for message in messages:
                self._call(message)
            if perf_counter() - began < SLOW_CALL:
                quick, share = quick + len(messages), min(2 * share, MOST_AT_ONCE)
            else:
                quick, share = 0, 1


class InlineCaller:
    """Calls the callback in the thread that received the message, however long it takes.

    Nobody reads that connection meanwhile, so a slow callback makes its publisher's queue fill, and of what
    one read brings, only the last `queue_size` messages are called with. That is rospy's way, and programs
    written for rospy rely on it: messages of one publisher come one after the other in one thread; those of
    two publishers may come at the same time.
    """

    takes_all = False

    def __init__(self, callback: Callable[[Any], object], inbox: Inbox, topic: str) -> None:
        self._callback = callback
        self._inbox = inbox
        self._topic = topic

    def offer(self, batch: Sequence[Any], stamp: float) -> None:
        """Call with each of the last messages; called by link threads."""
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

    def begin(self, batch: Sequence[Any], stamp: float) -> None:
        """Have the callback called with these, in a thread of their own."""
        name = f"rosproto:callback {self._topic}"
        threading.Thread(target=self.offer, args=(batch, stamp), name=name, daemon=True).start()

    def offer_one(self, message: Any) -> None:
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

    def _log_error(self) -> None:
        _log.exception("! %s: the callback %r raised; the subscriber goes on", self._topic, self._callback)
