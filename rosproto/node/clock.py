"""The node's time: this computer's, or the simulated time of /clock.

`/use_sim_time` is read once, when the node is opened. Simulated time is 0 before the first
message of /clock, stops when /clock stops, and may jump back when a bag is played again, which wakes all
sleeping threads.

Source: wiki.ros.org/Clock; rospy rostime.py and timer.py for Rate and Timer.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import NamedTuple

from rosproto.codec import DynamicMessage, message_class
from rosproto.coercion import as_float
from rosproto.logs import get_logger
from rosproto.time import Duration, Time
from rosproto.transport.deadline import wait_event

_log = get_logger("rosproto.node")

MAX_WAIT_SECONDS = 1.0  # seconds of real time between two checks for a closed node
NSEC = 1_000_000_000


class NodeClock:
    """Time, sleeping, rates and timers of one node.

    Attributes:
        simulated: True when time comes from /clock.
        ahead_nsec: Added to this computer's time, for a simulated robot whose clock differs from it.
        closing: Set when the node begins to close; None before `attach`.
    """

    def __init__(self) -> None:
        self.simulated = False
        self.ahead_nsec = 0
        self._condition = threading.Condition()
        self._now = 0  # simulated, nanoseconds
        self._jumps = 0
        self.closing: threading.Event | None = None
        self._timers: set[Timer] = set()
        self._on_jump: list[Callable[[], object]] = []

    def attach(self, closing: threading.Event, subscribe: Callable[..., object] | None = None) -> None:
        """Connect the clock to a node.

        Args:
            closing: Set when the node begins to close; the node then calls `close`.
            subscribe: `Node.subscriber`, to follow /clock; None for real time.
        """
        self.closing = closing
        self.simulated = subscribe is not None
        if subscribe is not None:
            subscribe("/clock", message_class("rosgraph_msgs/Clock"), self._on_clock, queue_size=1)

    @property
    def running(self) -> bool:
        """True while the node is open."""
        return self.closing is not None and not self.closing.is_set()

    @property
    def over(self) -> bool:
        """True once the node begins to close."""
        return self.closing is not None and self.closing.is_set()

    # -- time -----------------------------------------------------------------------------------------------

    def now_nsec(self) -> int:
        """Nanoseconds since 1970, or of simulated time."""
        return self._now if self.simulated else time.time_ns() + self.ahead_nsec

    def now(self) -> Time:
        """The present time; 0 in simulated time before the first /clock message."""
        return Time(*divmod(self.now_nsec(), NSEC))

    def on_jump(self, callback: Callable[[], object]) -> None:
        """Call `callback()` when simulated time jumps back."""
        self._on_jump.append(callback)

    def _on_clock(self, message: DynamicMessage) -> None:
        stamp: int = message.clock.secs * NSEC + message.clock.nsecs
        with self._condition:
            back = stamp < self._now
            self._jumps += back
            self._now = stamp
            self._condition.notify_all()
        if back:
            _log.info("= /clock jumped back to %d.%09d", *divmod(stamp, NSEC))
            for callback in self._on_jump:
                callback()

    def wait_for_time(self, timeout: float | None = 10.0) -> bool:
        """Wait for the first /clock message; return True at once with real time."""
        with self._condition:
            return not self.simulated or self._wait(lambda: self._now > 0, timeout)

    # -- sleeping -------------------------------------------------------------------------------------------

    def sleep(self, duration: float | Duration) -> bool:
        """Sleep by this clock.

        Returns:
            True after the whole time; False when woken early, because simulated time jumped back or the node
            was closed.
        """
        seconds = duration.to_sec() if isinstance(duration, Duration) else as_float(duration)
        return self.sleep_until_nsec(self.now_nsec() + round(seconds * NSEC))

    def sleep_until_nsec(self, end: int, stop: threading.Event | None = None) -> bool:
        """As `sleep`, until the time `end` in nanoseconds; `stop` ends it too, within a second."""
        if not self.simulated:
            return self._sleep_real((end - self.now_nsec()) / NSEC, stop)
        with self._condition:
            jumps = self._jumps
            self._wait(
                lambda: self._now >= end or self._jumps != jumps or (stop is not None and stop.is_set()), None
            )
            return self._now >= end and self._jumps == jumps

    def _sleep_real(self, seconds: float, stop: threading.Event | None) -> bool:
        closing = stop or self.closing or threading.Event()
        return not wait_event(closing, max(0.0, seconds))

    def _wait(self, done: Callable[[], bool], timeout: float | None) -> bool:
        """Wait for simulated time, until the node closes. The caller holds the lock."""
        end = None if timeout is None else time.monotonic() + as_float(timeout)
        while not done():
            if not self.running:
                return False
            left = MAX_WAIT_SECONDS if end is None else min(MAX_WAIT_SECONDS, end - time.monotonic())
            if left <= 0:
                return False
            self._condition.wait(left)
        return True

    def rate(self, hz: float) -> Rate:
        """Make a `Rate` for a loop: `while rate.sleep(): ...`."""
        return Rate(self, hz)

    def timer(
        self, period: float, callback: Callable[[TimerEvent], object], *, oneshot: bool = False
    ) -> Timer:
        """Call `callback(event)` every `period` seconds, in a separate thread.

        Args:
            period: Seconds of this clock.
            callback: Gets a `TimerEvent`. Its exceptions are logged, and the timer continues.
            oneshot: Call it once.
        """
        timer = Timer(self, period, callback, oneshot)
        self._timers.add(timer)
        timer._thread.start()
        return timer

    def close(self) -> None:
        """End all timers and wake all sleeping threads; called when the node closes."""
        with self._condition:
            self._condition.notify_all()
        timers = list(self._timers)
        for timer in timers:
            timer._stop.set()
        for timer in timers:
            timer.close()


class Rate:
    """Keeps a loop at `hz` rounds per second of the node's clock, without making up for missed rounds."""

    def __init__(self, clock: NodeClock, hz: float) -> None:
        if not hz > 0:
            raise ValueError(f"a rate must be a positive number of cycles per second, not {hz!r}")
        self._clock = clock
        self._period = round(NSEC / as_float(hz))
        self._last = clock.now_nsec()

    def remaining(self) -> float:
        """Seconds left of this round; negative when it is late."""
        return (self._last + self._period - self._clock.now_nsec()) / NSEC

    def sleep(self) -> bool:
        """Sleep until the round is over; False when the node was closed, so `while rate.sleep()` ends."""
        now = self._clock.now_nsec()
        if now < self._last:  # time jumped back
            self._last = now
        due = self._last + self._period
        if now < due:
            self._clock.sleep_until_nsec(due)
            now = self._clock.now_nsec()
        # Late by more than a round: start again from now, as rospy Rate.sleep.
        self._last = due if now - due < self._period else now
        return self._clock.running


class TimerEvent(NamedTuple):
    """The argument of a timer's callback (rospy.timer.TimerEvent has the same names).

    Attributes:
        last_expected: Scheduled time of the previous call; None in the first call.
        last_real: Actual time of the previous call; None in the first call.
        current_expected: Scheduled time of this call.
        current_real: Actual time of this call.
        last_duration: Duration of the previous call, seconds of real time; None in the first call.
    """

    last_expected: Time | None
    last_real: Time | None
    current_expected: Time
    current_real: Time
    last_duration: float | None


class Timer:
    """Made by `NodeClock.timer`; close it to stop."""

    def __init__(
        self, clock: NodeClock, period: float, callback: Callable[[TimerEvent], object], oneshot: bool
    ) -> None:
        if not period > 0:
            raise ValueError(f"a timer's period must be a positive number of seconds, not {period!r}")
        self._clock = clock
        self._period = round(as_float(period) * NSEC)
        self._callback = callback
        self._oneshot = oneshot
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="rosproto:timer", daemon=True)

    def _run(self) -> None:
        clock = self._clock
        due = clock.now_nsec() + self._period
        last: tuple[Time, Time, float] | None = None
        while not self._stop.is_set():
            whole = clock.sleep_until_nsec(due, self._stop)
            if self._stop.is_set() or clock.over:
                break
            now = clock.now_nsec()
            if not whole and now < due:  # time jumped back: a period from now
                due = now + self._period
                continue
            last = self._call(due, now, last)
            if self._oneshot:
                break
            due += self._period
            if due < clock.now_nsec() - self._period:  # late by more than a period: do not make it up
                due = clock.now_nsec() + self._period
        clock._timers.discard(self)

    def _call(self, due: int, now: int, last: tuple[Time, Time, float] | None) -> tuple[Time, Time, float]:
        expected, real = Time(*divmod(due, NSEC)), Time(*divmod(now, NSEC))
        event = TimerEvent(
            last[0] if last else None, last[1] if last else None, expected, real, last[2] if last else None
        )
        began = time.perf_counter()
        try:
            self._callback(event)
        except BaseException:  # as in incoming/subscriber_queue.py
            _log.exception("! the timer's callback %r raised; the timer continues", self._callback)
        return expected, real, time.perf_counter() - began

    def close(self) -> None:
        """Stop the calls; wait up to 1 s for a running one, unless it is the caller."""
        self._stop.set()
        with self._clock._condition:
            self._clock._condition.notify_all()
        if threading.current_thread() is not self._thread and self._thread.ident is not None:
            self._thread.join(1.0)

    def __enter__(self) -> Timer:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()
