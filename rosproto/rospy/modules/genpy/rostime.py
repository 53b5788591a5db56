"""genpy.Time and genpy.Duration: rosproto's, with genpy's texts and results."""

from numbers import Integral

from rosproto.time import Duration as _Duration
from rosproto.time import Time as _Time
from rosproto.time import TVal


def _set(self, secs, nsecs):
    if not isinstance(secs, Integral):
        if nsecs != 0:
            raise ValueError("if secs is a float, nsecs cannot be set")
        whole = int(secs)
        nsecs = int((secs - whole) * 1000000000)
        secs = whole
    over, nsecs = divmod(int(nsecs), 1000000000)
    self.secs = int(secs) + over
    self.nsecs = nsecs


class Time(_Time):
    """A point in time: secs and nsecs."""

    __slots__ = ()

    def __init__(self, secs=0, nsecs=0):
        _set(self, secs, nsecs)
        if self.secs < 0:
            raise TypeError("time values must be positive")

    def __sub__(self, other):
        if isinstance(other, _Time):
            return Duration(self.secs - other.secs, self.nsecs - other.nsecs)
        if isinstance(other, _Duration):
            return self.__class__(self.secs - other.secs, self.nsecs - other.nsecs)
        return NotImplemented

    to_time = _Time.to_sec

    def __repr__(self):
        return "genpy.Time[%d]" % self.to_nsec()


class Duration(_Duration):
    """A span of time: secs and nsecs; may be negative."""

    __slots__ = ()

    def __init__(self, secs=0, nsecs=0):
        _set(self, secs, nsecs)

    def __repr__(self):
        return "genpy.Duration[%d]" % self.to_nsec()


# For code that goes through the slots of messages and of times alike; the slots themselves are TVal's.
Time.__slots__ = Duration.__slots__ = ["secs", "nsecs"]
