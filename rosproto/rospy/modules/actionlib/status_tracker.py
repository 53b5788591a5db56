"""An action server's record of one goal."""

import rospy
from actionlib_msgs.msg import GoalStatus

from .goal_id_generator import GoalIDGenerator


class StatusTracker:
    """One goal: created by the goal, or by a cancel that arrived before it."""

    def __init__(self, goal_id=None, status=None, goal=None):
        self.goal = None
        self.handle_tracker = None
        self.handle_destruction_time = rospy.Time()
        self.status = GoalStatus()
        if goal_id:
            self.status.goal_id = goal_id
            self.status.status = status
            return
        self.goal = goal
        self.status.goal_id = goal.goal_id
        self.status.status = GoalStatus.PENDING
        if self.status.goal_id.id == "":
            self.status.goal_id = GoalIDGenerator().generate_ID()
        if self.status.goal_id.stamp == rospy.Time():
            self.status.goal_id.stamp = rospy.Time.now()
