"""ActionClient: sends goals and follows them through the states of actionlib's client.

The states and transitions are those of `rosproto.protocol.goal_client`. As in rospy, callbacks run at once in
the receiving thread, in the order of the states.
"""

import itertools
import threading
import time
import weakref

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray

from rosproto.protocol.goal_client import CommState as _State
from rosproto.protocol.goal_client import transition_path
from rosproto.protocol.goal_status import GoalStatus as _Status

from .exceptions import ActionException

_counter = itertools.count(1)
ZERO = rospy.Duration(0.0)
# Seconds that a result waits for feedback that was sent before it. They come by two connections, and feedback
# read after the result is not reported. rospy is slower by about that much (measured).
GRACE = 0.002


def get_name_of_constant(C, n):
    """Name of the integer constant with this value in a class."""
    for name, value in C.__dict__.items():
        if isinstance(value, int) and value == n:
            return name
    return "NO_SUCH_STATE_%d" % n


class CommState:
    """States of a goal as its client sees it."""

    WAITING_FOR_GOAL_ACK = 0
    PENDING = 1
    ACTIVE = 2
    WAITING_FOR_RESULT = 3
    WAITING_FOR_CANCEL_ACK = 4
    RECALLING = 5
    PREEMPTING = 6
    DONE = 7
    LOST = 8


class TerminalState:
    """How a goal may end."""

    RECALLED = GoalStatus.RECALLED
    REJECTED = GoalStatus.REJECTED
    PREEMPTED = GoalStatus.PREEMPTED
    ABORTED = GoalStatus.ABORTED
    SUCCEEDED = GoalStatus.SUCCEEDED
    LOST = GoalStatus.LOST


GoalStatus.to_string = CommState.to_string = TerminalState.to_string = classmethod(get_name_of_constant)


class ClientGoalHandle:
    """A program's handle of one goal. When the last handle is dropped, the goal is no longer followed."""

    def __init__(self, comm_state_machine):
        self.comm_state_machine = comm_state_machine

    def __eq__(self, other):
        return bool(other) and self.comm_state_machine is other.comm_state_machine

    def __ne__(self, other):
        return not self == other

    def __hash__(self):
        return hash(self.comm_state_machine.action_goal.goal_id.id)

    def cancel(self):
        """Ask the server to cancel it."""
        machine = self.comm_state_machine
        with machine.mutex:
            machine.send_cancel_fn(GoalID(stamp=rospy.Time(0), id=machine.action_goal.goal_id.id))
            machine.transition_to(CommState.WAITING_FOR_CANCEL_ACK)

    def get_comm_state(self):
        """Its CommState."""
        return self.comm_state_machine.state

    def get_goal_status(self):
        """Return the last status from the server."""
        return self.comm_state_machine.latest_goal_status.status

    def get_goal_status_text(self):
        """The server's words."""
        return self.comm_state_machine.latest_goal_status.text

    def get_result(self):
        """The result message, None before it came."""
        latest = self.comm_state_machine.latest_result
        return None if latest is None else latest.result

    def get_terminal_state(self):
        """How it ended."""
        machine = self.comm_state_machine
        with machine.mutex:
            if machine.state != CommState.DONE:
                rospy.logwarn(
                    "Asking for the terminal state when we're in [%s]", CommState.to_string(machine.state)
                )
            status = machine.latest_goal_status.status
            if status in vars(TerminalState).values():
                return status
            rospy.logerr("Asking for a terminal state, but the goal status is %d", status)
            return GoalStatus.LOST


class CommStateMachine:
    """State of one goal.

    Attributes:
        feedback_awaited: There is a feedback callback; feedback is delivered before the result.
    """

    def __init__(self, action_goal, transition_cb, feedback_cb, send_goal_fn, send_cancel_fn):
        self.action_goal = action_goal
        self.transition_cb = transition_cb
        self.feedback_cb = feedback_cb
        self.feedback_awaited = feedback_cb is not None
        self.send_goal_fn = send_goal_fn
        self.send_cancel_fn = send_cancel_fn
        self.state = CommState.WAITING_FOR_GOAL_ACK
        self.mutex = threading.RLock()
        self.latest_goal_status = GoalStatus(status=GoalStatus.PENDING)
        self.latest_result = None
        self._active_since = None  # stamp of the feedback that showed it, until a status array does

    @property
    def goal_id(self):
        """Its id."""
        return self.action_goal.goal_id.id

    def update_status(self, status_array):
        """A status array arrived."""
        with self.mutex:
            if self.state == CommState.DONE:
                return
            status = next((one for one in status_array.status_list if one.goal_id.id == self.goal_id), None)
            if status is None:
                # An array may be older than feedback received before it: both have the server's time.
                overtaken = self._active_since is not None and status_array.header.stamp <= self._active_since
                if not overtaken and self.state not in (
                    CommState.WAITING_FOR_GOAL_ACK,
                    CommState.WAITING_FOR_RESULT,
                ):
                    self.latest_goal_status.status = GoalStatus.LOST
                    self.transition_to(CommState.DONE)
                return
            self._active_since = None
            self._heard(status)

    def _heard(self, status):
        self.latest_goal_status = status
        try:
            path = transition_path(_State(self.state), _Status(status.status))
        except ValueError:
            rospy.logerr("Got an unknown status from the ActionServer: %i" % status.status)
            return
        if path is None:
            rospy.logerr(
                "Invalid goal status transition from %s to %s"
                % (CommState.to_string(self.state), GoalStatus.to_string(status.status))
            )
            return
        for state in path:
            self.transition_to(int(state))

    def transition_to(self, state):
        """Enter a state and report it."""
        rospy.logdebug(
            "Transitioning to %s (from %s, goal: %s)",
            CommState.to_string(state),
            CommState.to_string(self.state),
            self.goal_id,
        )
        self.state = state
        if self.transition_cb:
            self.transition_cb(ClientGoalHandle(self))

    def update_result(self, action_result):
        """The result arrived."""
        with self.mutex:
            if self.state == CommState.DONE:
                self.latest_goal_status = action_result.status
                self.latest_result = action_result
                rospy.logerr("Got a result when we were already in the DONE state")
                return
            self.latest_result = action_result
            self._heard(action_result.status)
            self.transition_to(CommState.DONE)

    def update_feedback(self, action_feedback):
        """Feedback arrived."""
        with self.mutex:
            # Feedback and status use separate connections. Feedback implies an active goal, too: call
            # active_cb first, as when the status is faster.
            early = self.state in (CommState.WAITING_FOR_GOAL_ACK, CommState.PENDING)
            if early and action_feedback.status.status in (GoalStatus.ACTIVE, GoalStatus.PREEMPTING):
                self._active_since = action_feedback.header.stamp
                self._heard(action_feedback.status)
        if self.feedback_cb and self.state != CommState.DONE:
            self.feedback_cb(ClientGoalHandle(self), action_feedback.feedback)


def message_classes(spec):
    """Classes of an action's goal, result and feedback messages."""
    try:
        action = spec()
        return type(action.action_goal), type(action.action_result), type(action.action_feedback)
    except AttributeError:
        raise ActionException("Type is not an action spec: %s" % str(spec))


class GoalManager:
    """The goals of a client, by id."""

    def __init__(self, ActionSpec):
        self.ActionSpec = ActionSpec
        self.ActionGoal, self.ActionResult, self.ActionFeedback = message_classes(ActionSpec)
        self.send_goal_fn = self.cancel_fn = None
        self._machines = weakref.WeakValueDictionary()
        self._lock = threading.RLock()

    def register_send_goal_fn(self, fn):
        """Set the function that publishes a goal."""
        self.send_goal_fn = fn

    def register_cancel_fn(self, fn):
        """Set the function that publishes a GoalID to cancel."""
        self.cancel_fn = fn

    def init_goal(self, goal, transition_cb=None, feedback_cb=None):
        """Follow a goal and send it; returns its handle."""
        handle = self.track_goal(goal, transition_cb, feedback_cb)
        self.send_goal_fn(handle.comm_state_machine.action_goal)
        return handle

    def track_goal(self, goal, transition_cb, feedback_cb):
        """Follow a goal before the caller publishes it, so that no answer is missed; returns its handle."""
        now = rospy.Time.now()
        goal_id = GoalID(stamp=now, id="%s-%i-%.3f" % (rospy.get_caller_id(), next(_counter), now.to_sec()))
        action_goal = self.ActionGoal(goal_id=goal_id, goal=goal)
        action_goal.header.stamp = rospy.get_rostime()
        machine = CommStateMachine(action_goal, transition_cb, feedback_cb, self.send_goal_fn, self.cancel_fn)
        with self._lock:
            self._machines[goal_id.id] = machine
        return ClientGoalHandle(machine)

    def update_statuses(self, status_array):
        """Note a GoalStatusArray."""
        with self._lock:
            machines = list(self._machines.values())
        for machine in machines:
            machine.update_status(status_array)

    def update_results(self, action_result):
        """Note a result."""
        machine = self._machines.get(action_result.status.goal_id.id)
        if machine is not None:
            if machine.feedback_awaited:
                time.sleep(GRACE)
            machine.update_result(action_result)

    def update_feedbacks(self, action_feedback):
        """Note feedback."""
        machine = self._machines.get(action_feedback.status.goal_id.id)
        if machine is not None:
            machine.update_feedback(action_feedback)


class ActionClient:
    """A client of one action server, for any number of goals."""

    def __init__(self, ns, ActionSpec):
        self.ns = ns
        self.last_status_msg = None
        self.ActionSpec = ActionSpec
        self.manager = GoalManager(ActionSpec)
        self.ActionGoal = self.manager.ActionGoal
        self.ActionResult, self.ActionFeedback = self.manager.ActionResult, self.manager.ActionFeedback
        self.pub_queue_size = rospy.get_param("actionlib_client_pub_queue_size", 10)
        if self.pub_queue_size < 0:
            self.pub_queue_size = 10
        self.sub_queue_size = rospy.get_param("actionlib_client_sub_queue_size", -1)
        if self.sub_queue_size < 0:
            self.sub_queue_size = None
        name = rospy.remap_name(ns)
        self.pub_goal = rospy.Publisher(name + "/goal", self.ActionGoal, queue_size=self.pub_queue_size)
        self.pub_cancel = rospy.Publisher(name + "/cancel", GoalID, queue_size=self.pub_queue_size)
        self.manager.register_send_goal_fn(self.pub_goal.publish)
        self.manager.register_cancel_fn(self.pub_cancel.publish)

        def subscribe(part, kind, callback):
            return rospy.Subscriber(name + part, kind, callback=callback, queue_size=self.sub_queue_size)

        self.status_sub = subscribe("/status", GoalStatusArray, self._status_cb)
        self.result_sub = subscribe("/result", self.ActionResult, self._result_cb)
        self.feedback_sub = subscribe("/feedback", self.ActionFeedback, self._feedback_cb)
        GoalStatus()  # generate its constructor now, not in the first `send_goal`

    def stop(self):
        """Unregister all topics."""
        for part in (self.pub_goal, self.pub_cancel, self.status_sub, self.result_sub, self.feedback_sub):
            part.unregister()

    def send_goal(self, goal, transition_cb=None, feedback_cb=None):
        """Send a goal; `transition_cb(handle)`, `feedback_cb(handle, feedback)`; returns its handle."""
        return self.manager.init_goal(goal, transition_cb, feedback_cb)

    def cancel_all_goals(self):
        """Ask the server to cancel every goal it has."""
        self.pub_cancel.publish(GoalID(stamp=rospy.Time.from_sec(0.0), id=""))

    def cancel_goals_at_and_before_time(self, time):
        """Ask the server to cancel every goal sent at or before a time."""
        self.pub_cancel.publish(GoalID(stamp=time, id=""))

    def wait_for_action_server_to_start(self, timeout=ZERO):
        """The old name of `wait_for_server`."""
        return self.wait_for_server(timeout)

    def wait_for_server(self, timeout=ZERO):
        """Wait until a server is connected on all topics; False when time is up. Zero means no limit."""
        end = rospy.get_rostime() + timeout
        while not rospy.is_shutdown():
            if self.last_status_msg and self._is_connected(
                self.last_status_msg._connection_header["callerid"]
            ):
                return True
            if timeout != ZERO and rospy.get_rostime() >= end:
                return False
            time.sleep(0.01)
        return False

    def _is_connected(self, server):
        return (
            self.pub_goal.impl.has_connection(server)
            and self.pub_cancel.impl.has_connection(server)
            and any(link.callerid_pub == server for link in self.result_sub.impl.connections)
            and any(link.callerid_pub == server for link in self.feedback_sub.impl.connections)
        )

    def _status_cb(self, message):
        self.last_status_msg = message
        self.manager.update_statuses(message)

    def _result_cb(self, message):
        self.manager.update_results(message)

    def _feedback_cb(self, message):
        self.manager.update_feedbacks(message)
