"""rospy.timer: sleep, Rate, Timer."""

import threading
import time
from dataclasses import dataclass

import genpy

from . import core, rostime
from .exceptions import ROSInterruptException, ROSTimeMovedBackwardsException


def sleep(duration):
    """Sleep by the node's clock; end early if the node shuts down, for example by Ctrl-C.

    With wall-clock time it then returns at once, while rospy 1.15 sleeps to the end; with simulated time it
    raises, as rospy does (measured).

    Raises:
        ROSInterruptException: The node was shut down, and time is simulated.
        ROSTimeMovedBackwardsException: Simulated time jumped back.
    """
    if rostime.is_wallclock():
        if isinstance(duration, genpy.TVal):
            duration = duration.to_sec()
        if duration < 0:
            return
        rostime.wallsleep(duration)
    else:
        _sleep_simulated(duration if isinstance(duration, genpy.TVal) else genpy.Duration.from_sec(duration))


def _sleep_simulated(duration):
    changed = rostime.get_rostime_cond()
    began = rostime.get_rostime()
    while began == genpy.Time(0) and not core.is_shutdown():  # no /clock message yet
        with changed:
            changed.wait(0.3)
        began = rostime.get_rostime()
    end = began + duration
    while began <= rostime.get_rostime() < end and not core.is_shutdown():
        with changed:
            changed.wait(0.1)
    now = rostime.get_rostime()
    if now < began:
        raise ROSTimeMovedBackwardsException((began - now).to_sec())
    if core.is_shutdown():
        raise ROSInterruptException("ROS shutdown request")


class Rate:
    """Run a loop at `hz` cycles per second."""

    def __init__(self, hz, reset=False):
        self.last_time = rostime.get_rostime()
        self.sleep_dur = rostime.Duration(0, int(1e9 / hz))
        self._reset = reset

    def _remaining(self, now):
        if self.last_time > now:  # time jumped back
            self.last_time = now
        return self.sleep_dur - (now - self.last_time)

    def remaining(self):
        """Time until the end of this cycle."""
        return self._remaining(rostime.get_rostime())

    def sleep(self):
        """Sleep until the end of this cycle.

        Raises:
            ROSInterruptException: The node was shut down.
            ROSTimeMovedBackwardsException: Simulated time jumped back (unless `reset`).
        """
        now = rostime.get_rostime()
        try:
            sleep(self._remaining(now))
        except ROSTimeMovedBackwardsException:
            if not self._reset:
                raise
            self.last_time = rostime.get_rostime()
            return
        self.last_time = self.last_time + self.sleep_dur
        if now - self.last_time > self.sleep_dur * 2:  # too slow, or time jumped: restart
            self.last_time = now


@dataclass(eq=False)
class TimerEvent:
    """Argument of a timer's callback.

    Attributes:
        last_expected, last_real: Scheduled and real time of the previous call; None in the first call.
        current_expected, current_real: Scheduled and real time of this call.
        last_duration: Duration of the previous call in seconds.
    """

    last_expected: rostime.Time
    last_real: rostime.Time
    current_expected: rostime.Time
    current_real: rostime.Time
    last_duration: float


class Timer(threading.Thread):
    """Call `callback(event)` every `period` in a separate thread, until `shutdown`."""

    def __init__(self, period, callback, oneshot=False, reset=False):
        super().__init__()
        self._period = period
        self._callback = callback
        self._oneshot = oneshot
        self._reset = reset
        self._shutdown = False
        self.daemon = True
        self.start()

    def shutdown(self):
        """Stop the calls."""
        self._shutdown = True

    def run(self):
        """Call the callback until `shutdown`."""
        rate = Rate(1.0 / self._period.to_sec(), reset=self._reset)
        expected = rostime.get_rostime() + self._period
        last_expected = last_real = last_duration = None
        while not core.is_shutdown() and not self._shutdown:
            try:
                rate.sleep()
            except ROSInterruptException:
                if core.is_shutdown():
                    break
                raise
            if self._shutdown:
                break
            real = rostime.get_rostime()
            began = time.monotonic()
            self._callback(TimerEvent(last_expected, last_real, expected, real, last_duration))
            if self._oneshot:
                break
            last_duration = time.monotonic() - began
            last_expected, last_real = expected, real
            expected += self._period
