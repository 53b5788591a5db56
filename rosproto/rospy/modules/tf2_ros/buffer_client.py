"""tf2_ros.BufferClient: lookups on a buffer server, through an action."""

import actionlib
import rospy
import tf2_py as tf2
from actionlib_msgs.msg import GoalStatus
from tf2_msgs.msg import LookupTransformAction, LookupTransformGoal

from .buffer_interface import ZERO, BufferInterface

_ERRORS = {
    1: tf2.LookupException,
    2: tf2.ConnectivityException,
    3: tf2.ExtrapolationException,
    4: tf2.InvalidArgumentException,
    5: tf2.TimeoutException,
}

PADDING = rospy.Duration.from_sec(2.0)


class BufferClient(BufferInterface):
    """A client of the buffer server at namespace `ns`."""

    def __init__(self, ns, check_frequency=None, timeout_padding=PADDING):
        super().__init__()
        if check_frequency is not None:
            rospy.logwarn("Argument check_frequency is deprecated and should not be used.")
        self.client = actionlib.SimpleActionClient(ns, LookupTransformAction)
        self.timeout_padding = timeout_padding

    def wait_for_server(self, timeout=ZERO):
        """True if the server becomes available within `timeout`."""
        return self.client.wait_for_server(timeout)

    def lookup_transform(self, target_frame, source_frame, time, timeout=ZERO):
        """The transform from source to target."""
        goal = LookupTransformGoal(target_frame=target_frame, source_frame=source_frame)
        goal.source_time, goal.timeout, goal.advanced = time, timeout, False
        return self._answer(goal)

    def lookup_transform_full(
        self, target_frame, target_time, source_frame, source_time, fixed_frame, timeout=ZERO
    ):
        """As `lookup_transform`, between two times."""
        goal = LookupTransformGoal(target_frame=target_frame, source_frame=source_frame)
        goal.source_time, goal.timeout, goal.advanced = source_time, timeout, True
        goal.target_time, goal.fixed_frame = target_time, fixed_frame
        return self._answer(goal)

    def can_transform(self, target_frame, source_frame, time, timeout=ZERO):
        """True if the transform is available within `timeout`."""
        return self._can(self.lookup_transform, target_frame, source_frame, time, timeout)

    def can_transform_full(
        self, target_frame, target_time, source_frame, source_time, fixed_frame, timeout=ZERO
    ):
        """As `can_transform`, between two times."""
        where = target_frame, target_time, source_frame, source_time, fixed_frame
        return self._can(self.lookup_transform_full, *where, timeout)

    @staticmethod
    def _can(look_up, *arguments):
        try:
            look_up(*arguments)
        except tf2.TransformException:
            return False
        return True

    def _answer(self, goal):
        self.client.send_goal(goal)
        if not self.client.wait_for_result(goal.timeout + self.timeout_padding):
            raise tf2.TimeoutException(
                "The LookupTransform goal sent to the BufferServer did not come back in the specified time."
                " Something is likely wrong with the server"
            )
        if self.client.get_state() != GoalStatus.SUCCEEDED:
            raise tf2.TimeoutException(
                "The LookupTransform goal sent to the BufferServer did not come back with SUCCEEDED status."
                " Something is likely wrong with the server."
            )
        result = self.client.get_result()
        if result.error.error:
            kind = _ERRORS.get(result.error.error, tf2.TransformException)
            raise kind(result.error.error_string)
        return result.transform
