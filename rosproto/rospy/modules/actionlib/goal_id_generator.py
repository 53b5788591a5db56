"""Goal ids: node name, number, time."""

import itertools

import rospy
from actionlib_msgs.msg import GoalID

_counter = itertools.count(1)


class GoalIDGenerator:
    """Makes unique ids."""

    def __init__(self, name=None):
        self.set_name(rospy.get_name() if name is None else name)

    def set_name(self, name):
        """Set the prefix of the ids."""
        self.name = name

    def generate_ID(self):
        """A new id."""
        now = rospy.Time.now()
        return GoalID(stamp=now, id="%s-%d-%d.%d" % (self.name, next(_counter), now.secs, now.nsecs))
