"""ServerGoalHandle: a server program's handle of one goal."""

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus

from rosproto.protocol.goal_server import next_status

_REFUSED = "To transition to %s state, the goal must be in a %s state, it is currently in state: %d"
_WORDS = {
    "accept": ("an active", "pending or recalling"),
    "reject": ("a rejected", "pending or recalling"),
    "cancel": ("a cancelled", "pending, recalling, active, or preempting"),
    "abort": ("an aborted", "preempting or active"),
    "succeed": ("a succeeded", "preempting or active"),
}


class ServerGoalHandle:
    """Changes the state of a goal and notifies the clients."""

    def __init__(self, status_tracker=None, action_server=None, handle_tracker=None):
        self.status_tracker = status_tracker
        self.action_server = action_server
        self.handle_tracker = handle_tracker
        self.goal = status_tracker.goal if status_tracker else None

    def get_default_result(self):
        """An empty result."""
        return self.action_server.ActionResultType()

    def set_accepted(self, text=""):
        """Start working on the goal."""
        self._do("accept", text)

    def set_canceled(self, result=None, text=""):
        """The goal is cancelled: RECALLED before it was accepted, PREEMPTED afterwards."""
        self._do("cancel", text, result)

    def set_rejected(self, result=None, text=""):
        """The goal will not be worked on."""
        self._do("reject", text, result)

    def set_aborted(self, result=None, text=""):
        """The goal failed."""
        self._do("abort", text, result)

    def set_succeeded(self, result=None, text=""):
        """The goal is reached."""
        self._do("succeed", text, result)

    def _do(self, command, text, result=None):
        if not self.goal:
            rospy.logerr("Attempt to set status on an uninitialized ServerGoalHandle")
            return
        with self.action_server.lock:
            tracker = self.status_tracker
            status = tracker.status
            after = next_status(status.status, command)
            if after is None:
                rospy.logerr(_REFUSED, *_WORDS[command], status.status)
                return
            status.status, status.text = int(after), text
            if not after.is_terminal:
                self.action_server.publish_status()
                return
            tracker.handle_destruction_time = rospy.Time.now()
            self.action_server.publish_result(status, result or self.get_default_result())

    def publish_feedback(self, feedback):
        """Publish feedback of the goal."""
        if not self.goal:
            rospy.logerr("Attempt to publish feedback on an uninitialized ServerGoalHandle")
            return
        with self.action_server.lock:
            self.action_server.publish_feedback(self.status_tracker.status, feedback)

    def get_goal(self):
        """The goal message; None when there is none."""
        return self.goal.goal if self.goal else None

    def get_goal_id(self):
        """Its id and stamp."""
        if not self.goal:
            rospy.logerr("Attempt to get a goal id on an uninitialized ServerGoalHandle")
            return GoalID()
        with self.action_server.lock:
            return self.status_tracker.status.goal_id

    def get_goal_status(self):
        """Its status message."""
        if not self.goal:
            rospy.logerr("Attempt to get goal status on an uninitialized ServerGoalHandle")
            return GoalStatus()
        with self.action_server.lock:
            return self.status_tracker.status

    def __eq__(self, other):
        if not self.goal or not other.goal:
            return False
        return self.get_goal_id().id == other.get_goal_id().id

    def __ne__(self, other):
        return not self == other

    def __hash__(self):
        return hash(self.get_goal_id().id)

    def set_cancel_requested(self):
        """Note a cancel request; True when the program must be notified."""
        if not self.goal:
            return False
        with self.action_server.lock:
            status = self.status_tracker.status
            after = next_status(status.status, "request_cancel")
            if after is None:
                return False
            status.status = int(after)
            self.action_server.publish_status()
            return True
