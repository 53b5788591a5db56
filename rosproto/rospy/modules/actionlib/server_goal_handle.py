"""ServerGoalHandle: one goal, as the program that serves it holds it."""

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus

_WAITING = (GoalStatus.PENDING, GoalStatus.RECALLING)
_RUNNING = (GoalStatus.ACTIVE, GoalStatus.PREEMPTING)


class ServerGoalHandle:
    """Moves a goal through its states and tells the clients."""

    def __init__(self, status_tracker=None, action_server=None, handle_tracker=None):
        self.status_tracker = status_tracker
        self.action_server = action_server
        self.handle_tracker = handle_tracker
        self.goal = status_tracker.goal if status_tracker else None

    def get_default_result(self):
        """An empty result."""
        return self.action_server.ActionResultType()

    def set_accepted(self, text=""):
        """The goal is being worked on from now on."""
        states = {GoalStatus.PENDING: GoalStatus.ACTIVE, GoalStatus.RECALLING: GoalStatus.PREEMPTING}
        if not self._is_there():
            return
        with self.action_server.lock:
            status = self.status_tracker.status
            if status.status not in states:
                rospy.logerr(
                    "To transition to an active state, the goal must be in a pending or recalling state,"
                    " it is currently in state: %d",
                    status.status,
                )
                return
            status.status = states[status.status]
            status.text = text
            self.action_server.publish_status()

    def set_canceled(self, result=None, text=""):
        """The goal is cancelled: RECALLED before it was begun, PREEMPTED afterwards."""
        states = dict.fromkeys(_WAITING, GoalStatus.RECALLED) | dict.fromkeys(_RUNNING, GoalStatus.PREEMPTED)
        self._end(
            states,
            result,
            text,
            "To transition to a cancelled state, the goal must be in a pending, recalling, active, or"
            " preempting state",
        )

    def set_rejected(self, result=None, text=""):
        """The goal will not be worked on."""
        self._end(
            dict.fromkeys(_WAITING, GoalStatus.REJECTED),
            result,
            text,
            "To transition to a rejected state, the goal must be in a pending or recalling state",
        )

    def set_aborted(self, result=None, text=""):
        """The goal failed."""
        self._end(
            dict.fromkeys(_RUNNING, GoalStatus.ABORTED),
            result,
            text,
            "To transition to an aborted state, the goal must be in a preempting or active state",
        )

    def set_succeeded(self, result=None, text=""):
        """The goal is reached."""
        self._end(
            dict.fromkeys(_RUNNING, GoalStatus.SUCCEEDED),
            result,
            text,
            "To transition to a succeeded state, the goal must be in a preempting or active state",
        )

    def _end(self, states, result, text, complaint):
        if not self._is_there():
            return
        result = result or self.get_default_result()
        with self.action_server.lock:
            tracker = self.status_tracker
            if tracker.status.status not in states:
                rospy.logerr("%s, it is currently in state: %d", complaint, tracker.status.status)
                return
            tracker.status.status = states[tracker.status.status]
            tracker.status.text = text
            tracker.handle_destruction_time = rospy.Time.now()
            self.action_server.publish_result(tracker.status, result)

    def _is_there(self):
        if not self.goal:
            rospy.logerr("Attempt to set status on an uninitialized ServerGoalHandle")
        return bool(self.goal)

    def publish_feedback(self, feedback):
        """Tell the clients how it goes."""
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
        """A client wants it cancelled; True when the program is to be told."""
        states = {GoalStatus.PENDING: GoalStatus.RECALLING, GoalStatus.ACTIVE: GoalStatus.PREEMPTING}
        if not self.goal:
            return False
        with self.action_server.lock:
            status = self.status_tracker.status
            if status.status not in states:
                return False
            status.status = states[status.status]
            self.action_server.publish_status()
            return True
