"""rospy.rostime: wall-clock or simulated time."""

import threading
import time

import genpy

from .exceptions import ROSInitException

_rostime_initialized = False
_rostime_current = None
_rostime_cond = threading.Condition()

SLICE = 0.1  # seconds between checks for shutdown


class Duration(genpy.Duration):
    """A span of time."""

    __slots__ = ()

    def __repr__(self):
        return "rospy.Duration[%d]" % self.to_nsec()


class Time(genpy.Time):
    """A point in time."""

    __slots__ = ()

    def __repr__(self):
        return "rospy.Time[%d]" % self.to_nsec()

    @staticmethod
    def now():
        """Current ROS time."""
        return get_rostime()


Duration.__slots__ = Time.__slots__ = []  # they add no slots to genpy's


def set_rostime(t):
    """Set the simulated time."""
    if not isinstance(t, genpy.Time):
        raise ValueError("must be Time instance: %s" % t.__class__)
    global _rostime_current
    with _rostime_cond:
        _rostime_current = Time(t.secs, t.nsecs)
        _rostime_cond.notify_all()


_set_rostime = set_rostime  # rospy's name for it


def get_rostime():
    """Current ROS time.

    Raises:
        ROSInitException: `init_node` was not called, so it is unknown whether time is simulated.
    """
    if not _rostime_initialized:
        raise ROSInitException("time is not initialized. Have you called init_node()?")
    if _rostime_current is not None:
        return _rostime_current
    now = time.time()
    secs = int(now)
    return Time(secs, int((now - secs) * 1000000000))


def get_time():
    """Current ROS time in seconds, a float."""
    return Time.now().to_sec()


def set_rostime_initialized(val):
    """Set whether the time is available."""
    global _rostime_initialized
    _rostime_initialized = val


def is_rostime_initialized():
    """True if the time is available."""
    return _rostime_initialized


def get_rostime_cond():
    """The condition that every step of simulated time notifies."""
    return _rostime_cond


def is_wallclock():
    """True unless time is simulated."""
    return _rostime_current is None


def switch_to_wallclock():
    """Switch from simulated time to the wall clock."""
    global _rostime_current
    with _rostime_cond:
        _rostime_current = None
        _rostime_cond.notify_all()


def wallsleep(duration):
    """Sleep by the wall clock; return early if the node shuts down.

    Sleeps in steps: time.sleep continues after a signal, and a signal handler must not set an Event.
    """
    from . import core

    end = time.monotonic() + duration
    was_shutdown = core.is_shutdown()
    while (left := end - time.monotonic()) > 0 and core.is_shutdown() == was_shutdown:
        time.sleep(min(left, SLICE))
