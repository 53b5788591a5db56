"""What is known of one frame: its poses in its parent over the last seconds, or one that always holds.

Times are nanoseconds. Source: tf2 cache.cpp and static_cache.cpp.
"""

from collections import namedtuple

from ._rotation import lerp, slerp

Pose = namedtuple("Pose", "stamp parent translation rotation")

OLD = (
    "TF_OLD_DATA ignoring data from the past"
    " (Possible reasons are listed at http://wiki.ros.org/tf/Errors%%20explained)"
)
REPEATED = "TF_REPEATED_DATA ignoring data with redundant timestamp"


def seconds(stamp):
    """Nanoseconds as roscpp's toSec() gives them."""
    whole, rest = divmod(stamp, 1000000000)
    return float(whole) + 1e-9 * rest


class TimeCache:
    """A frame that moves; the newest pose is first in `poses`."""

    def __init__(self, duration):
        self._duration = duration
        self.poses = []

    def insert(self, pose):
        """Take a pose; why it was not taken, or None."""
        poses = self.poses
        if poses and poses[0].stamp > pose.stamp + self._duration:
            return OLD
        at = 0
        while at < len(poses) and poses[at].stamp > pose.stamp:
            at += 1
        if at < len(poses) and poses[at].stamp == pose.stamp:
            return REPEATED
        poses.insert(at, pose)
        oldest = poses[0].stamp - self._duration
        while poses[-1].stamp < oldest:
            poses.pop()
        return None

    def at(self, stamp):
        """(pose at a time, None), or (None, why not); 0 is the newest."""
        poses = self.poses
        if not poses:  # cleared: tf2 gives no reason
            return None, ""
        if stamp == 0:
            return poses[0], None
        newest, oldest = poses[0], poses[-1]
        if len(poses) == 1:
            if newest.stamp == stamp:
                return newest, None
            return None, (
                "Lookup would require extrapolation at time %.09f, but only time %.09f is in the buffer"
                % (seconds(stamp), seconds(newest.stamp))
            )[:115]  # so much does tf2 make room for
        if stamp == newest.stamp:
            return newest, None
        if stamp == oldest.stamp:
            return oldest, None
        if stamp > newest.stamp:
            return None, _beyond(stamp, newest.stamp, "future", "latest")
        if stamp < oldest.stamp:
            return None, _beyond(stamp, oldest.stamp, "past", "earliest")
        at = next(i for i, pose in enumerate(poses) if pose.stamp <= stamp)
        return _between(poses[at], poses[at - 1], stamp), None

    def newest(self):
        """(time, parent) of the newest pose; (0, None) when there is none."""
        return (self.poses[0].stamp, self.poses[0].parent) if self.poses else (0, None)

    def clear(self):
        """Forget all."""
        self.poses = []

    def span(self):
        """(newest, oldest, how many)."""
        return self.poses[0].stamp, self.poses[-1].stamp, len(self.poses)


class StaticCache:
    """A frame that does not move; its pose holds at all times."""

    def __init__(self):
        self.poses = []

    def insert(self, pose):
        """Take a pose in place of the one before."""
        self.poses = [pose]

    def at(self, stamp):
        """(pose, None)."""
        return self.poses[0]._replace(stamp=stamp), None

    def newest(self):
        """(0, parent): no time of its own."""
        return 0, self.poses[0].parent

    def clear(self):
        """It stays: what is static holds whatever the clock does."""

    def span(self):
        """(newest, oldest, how many)."""
        return 0, 0, 1


def _beyond(asked, known, where, which):
    return (
        "Lookup would require extrapolation %.09fs into the %s.  Requested time %.09f but the %s data is at"
        " time %.09f" % (seconds(abs(asked - known)), where, seconds(asked), which, seconds(known))
    )


def _between(one, other, stamp):
    if one.parent != other.parent:
        return one
    ratio = seconds(stamp - one.stamp) / seconds(other.stamp - one.stamp)
    return Pose(
        stamp,
        one.parent,
        lerp(one.translation, other.translation, ratio),
        slerp(one.rotation, other.rotation, ratio),
    )
