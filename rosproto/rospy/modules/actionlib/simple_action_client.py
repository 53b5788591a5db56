"""SimpleActionClient: one goal at a time."""

import threading

import rospy
from actionlib_msgs.msg import GoalStatus

from .action_client import ActionClient, CommState, get_name_of_constant

FOREVER = rospy.Duration()


class SimpleGoalState:
    """States of the one goal."""

    PENDING = 0
    ACTIVE = 1
    DONE = 2


SimpleGoalState.to_string = classmethod(get_name_of_constant)


class SimpleActionClient:
    """A client that follows the goal sent last."""

    def __init__(self, ns, ActionSpec):
        self.action_client = ActionClient(ns, ActionSpec)
        self.simple_state = SimpleGoalState.DONE
        self.gh = None
        self.done_condition = threading.Condition()
        self.done_cb = self.active_cb = self.feedback_cb = None

    def wait_for_server(self, timeout=FOREVER):
        """Wait until a server is connected; False when time is up. Zero means no limit."""
        return self.action_client.wait_for_server(timeout)

    def send_goal(self, goal, done_cb=None, active_cb=None, feedback_cb=None):
        """Send a goal; the previous one is no longer followed, and not cancelled.

        Args:
            goal: The goal message.
            done_cb: Called with (status, result) when it has ended.
            active_cb: Called without arguments when the server has started.
            feedback_cb: Called with each feedback message.
        """
        self.stop_tracking_goal()
        self.done_cb = done_cb
        self.active_cb = active_cb
        self.feedback_cb = feedback_cb
        self.simple_state = SimpleGoalState.PENDING
        # Followed before it is sent: the server may answer before publish() returns.
        client = self.action_client
        self.gh = client.manager.track_goal(goal, self._handle_transition, self._handle_feedback)
        machine = self.gh.comm_state_machine
        machine.feedback_awaited = feedback_cb is not None
        client.pub_goal.publish(machine.action_goal)

    def send_goal_and_wait(self, goal, execute_timeout=FOREVER, preempt_timeout=FOREVER):
        """Send a goal and wait for its end; cancel it when that takes too long. Returns its state."""
        self.send_goal(goal)
        if not self.wait_for_result(execute_timeout):
            rospy.logdebug("Canceling goal")
            self.cancel_goal()
            in_time = self.wait_for_result(preempt_timeout)
            rospy.logdebug(
                "Preempt %s specified preempt_timeout [%.2f]",
                "finished within" if in_time else "didn't finish",
                preempt_timeout.to_sec(),
            )
        return self.get_state()

    def wait_for_result(self, timeout=FOREVER):
        """Wait until the goal has ended, whatever its result; False when time is up. Zero means no limit."""
        if not self.gh:
            rospy.logerr("Called wait_for_result when no goal exists")
            return False
        end = rospy.get_rostime() + timeout
        with self.done_condition:
            while not rospy.is_shutdown() and self.simple_state != SimpleGoalState.DONE:
                left = 0.1
                if timeout > FOREVER:
                    left = min(left, (end - rospy.get_rostime()).to_sec())
                    if left <= 0:
                        break
                self.done_condition.wait(left)
        return self.simple_state == SimpleGoalState.DONE

    def get_result(self):
        """The result message; None before it came."""
        if not self.gh:
            rospy.logerr("Called get_result when no goal is running")
            return None
        return self.gh.get_result()

    def get_state(self):
        """GoalStatus of the goal, LOST when there is none."""
        if not self.gh:
            return GoalStatus.LOST
        status = self.gh.get_goal_status()
        if status == GoalStatus.RECALLING:
            return GoalStatus.PENDING
        if status == GoalStatus.PREEMPTING:
            return GoalStatus.ACTIVE
        return status

    def get_goal_status_text(self):
        """The server's words."""
        if not self.gh:
            rospy.logerr("Called get_goal_status_text when no goal is running")
            return "ERROR: Called get_goal_status_text when no goal is running"
        return self.gh.get_goal_status_text()

    def cancel_all_goals(self):
        """Ask the server to cancel every goal it has."""
        self.action_client.cancel_all_goals()

    def cancel_goals_at_and_before_time(self, time):
        """Ask the server to cancel every goal sent at or before a time."""
        self.action_client.cancel_goals_at_and_before_time(time)

    def cancel_goal(self):
        """Ask the server to cancel this goal; returns at once."""
        if self.gh:
            self.gh.cancel()

    def stop_tracking_goal(self):
        """Stop following the goal; the server continues it."""
        self.gh = None

    def _handle_transition(self, gh):
        if gh != self.gh:
            rospy.logerr("Got a transition callback on a goal handle that we're not tracking")
            return
        state, simple = gh.get_comm_state(), self.simple_state
        if state in (CommState.ACTIVE, CommState.PREEMPTING) and simple == SimpleGoalState.PENDING:
            self.simple_state = SimpleGoalState.ACTIVE
            if self.active_cb:
                self.active_cb()
        elif state == CommState.DONE:
            self._handle_done(gh)
        elif self._is_wrong(state, simple):
            rospy.logerr(
                "Received comm state %s when in simple state %s with SimpleActionClient in NS %s"
                % (
                    CommState.to_string(state),
                    SimpleGoalState.to_string(simple),
                    rospy.resolve_name(self.action_client.ns),
                )
            )

    @staticmethod
    def _is_wrong(state, simple):
        if state == CommState.RECALLING:
            return simple != SimpleGoalState.PENDING
        return state in (CommState.ACTIVE, CommState.PREEMPTING) and simple == SimpleGoalState.DONE

    def _handle_done(self, gh):
        if self.simple_state == SimpleGoalState.DONE:
            rospy.logerr("SimpleActionClient received DONE twice")
            return
        if self.done_cb:
            self.done_cb(gh.get_goal_status(), gh.get_result())
        with self.done_condition:
            self.simple_state = SimpleGoalState.DONE
            self.done_condition.notify_all()

    def _handle_feedback(self, gh, feedback):
        if not self.gh:
            return  # of a goal no longer followed
        if gh != self.gh:
            rospy.logerr(
                "Got a feedback callback on a goal handle that we're not tracking. %s vs %s"
                % (self.gh.comm_state_machine.goal_id, gh.comm_state_machine.goal_id)
            )
            return
        if self.feedback_cb:
            self.feedback_cb(feedback)
