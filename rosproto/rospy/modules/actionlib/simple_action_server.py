"""SimpleActionServer: one goal at a time; a new one preempts the current one."""

import threading
import traceback

import rospy
from actionlib_msgs.msg import GoalStatus

from .action_server import ActionServer, nop_cb
from .server_goal_handle import ServerGoalHandle

_BUMPED = "This goal was canceled because another goal was received by the simple action server"


class SimpleActionServer:
    """Calls `execute_cb(goal)` in a separate thread; without it, call `accept_new_goal`."""

    def __init__(self, name, ActionSpec, execute_cb=None, auto_start=True):
        self.new_goal = False
        self.preempt_request = False
        self.new_goal_preempt_request = False
        self.execute_callback = execute_cb
        self.goal_callback = None
        self.preempt_callback = None
        self.need_to_terminate = False
        self.terminate_mutex = threading.RLock()
        # Taken after the action server's lock, never before it.
        self.lock = threading.RLock()
        self.execute_condition = threading.Condition(self.lock)
        self.current_goal = ServerGoalHandle()
        self.next_goal = ServerGoalHandle()
        self.execute_thread = None
        if execute_cb:
            self.execute_thread = threading.Thread(None, self.executeLoop)
            self.execute_thread.start()
        self.action_server = ActionServer(
            name, ActionSpec, self.internal_goal_callback, self.internal_preempt_callback, auto_start
        )

    def __del__(self):
        if getattr(self, "execute_callback", None):
            with self.terminate_mutex:
                self.need_to_terminate = True
            self.execute_thread.join()

    def start(self):
        """Begin to serve."""
        self.action_server.start()

    def accept_new_goal(self):
        """Accept the waiting goal and preempt the one before; returns its message, None when none waits."""
        with self.action_server.lock, self.lock:
            if not self.new_goal or not self.next_goal.get_goal():
                rospy.logerr("Attempting to accept the next goal when a new goal is not available")
                return None
            if self.is_active() and self.current_goal.get_goal() and self.current_goal != self.next_goal:
                self.current_goal.set_canceled(None, _BUMPED)
            self.current_goal = self.next_goal
            self.new_goal = False
            self.preempt_request = self.new_goal_preempt_request
            self.new_goal_preempt_request = False
            self.current_goal.set_accepted("This goal has been accepted by the simple action server")
            return self.current_goal.get_goal()

    def is_new_goal_available(self):
        """True when one waits."""
        return self.new_goal

    def is_preempt_requested(self):
        """True when the current goal should be preempted."""
        return self.preempt_request

    def is_active(self):
        """True while a goal is worked on."""
        if not self.current_goal.get_goal():
            return False
        return self.current_goal.get_goal_status().status in (GoalStatus.ACTIVE, GoalStatus.PREEMPTING)

    def set_succeeded(self, result=None, text=""):
        """The goal is reached."""
        with self.action_server.lock, self.lock:
            self.current_goal.set_succeeded(result or self.get_default_result(), text)

    def set_aborted(self, result=None, text=""):
        """The goal failed."""
        with self.action_server.lock, self.lock:
            self.current_goal.set_aborted(result or self.get_default_result(), text)

    def set_preempted(self, result=None, text=""):
        """The goal was preempted."""
        with self.action_server.lock, self.lock:
            self.current_goal.set_canceled(result or self.get_default_result(), text)

    def publish_feedback(self, feedback):
        """Publish feedback of the current goal."""
        self.current_goal.publish_feedback(feedback)

    def get_default_result(self):
        """An empty result."""
        return self.action_server.ActionResultType()

    def register_goal_callback(self, cb):
        """Call this when a goal waits; not together with `execute_cb`."""
        if self.execute_callback:
            rospy.logwarn(
                "Cannot call SimpleActionServer.register_goal_callback() because an executeCallback exists."
                " Not going to register it."
            )
        else:
            self.goal_callback = cb

    def register_preempt_callback(self, cb):
        """Call this when the current goal should be preempted."""
        self.preempt_callback = cb

    def internal_goal_callback(self, goal):
        """A goal arrived; the action server's lock is held."""
        with self.execute_condition:
            try:
                self._take(goal)
            except Exception as error:
                rospy.logerr("SimpleActionServer.internal_goal_callback - exception %s", str(error))

    def _take(self, goal):
        stamp, current, waiting = goal.get_goal_id().stamp, self.current_goal, self.next_goal
        if any(known.get_goal() and stamp < known.get_goal_id().stamp for known in (current, waiting)):
            goal.set_canceled(None, _BUMPED)
            return
        if waiting.get_goal() and (not current.get_goal() or waiting != current):
            waiting.set_canceled(None, _BUMPED)
        self.next_goal = goal
        self.new_goal = True
        self.new_goal_preempt_request = False
        if self.is_active():
            self.preempt_request = True
            if self.preempt_callback:
                self.preempt_callback()
        if self.goal_callback:
            self.goal_callback()
        self.execute_condition.notify()

    def internal_preempt_callback(self, preempt):
        """A cancel arrived; the action server's lock is held."""
        with self.lock:
            if preempt == self.current_goal:
                self.preempt_request = True
                if self.preempt_callback:
                    self.preempt_callback()
            elif preempt == self.next_goal:
                self.new_goal_preempt_request = True

    def executeLoop(self):
        """Work on goals until the node is shut down."""
        while not rospy.is_shutdown():
            with self.terminate_mutex:
                if self.need_to_terminate:
                    break
            if self.is_active():
                rospy.logerr("Should never reach this code with an active goal")
                return
            if self.is_new_goal_available():
                self._execute(self.accept_new_goal())
            with self.execute_condition:
                if not self.new_goal:
                    self.execute_condition.wait(0.1)

    def _execute(self, goal):
        try:
            self.execute_callback(goal)
            if self.is_active():
                rospy.logwarn(
                    "Your executeCallback did not set the goal to a terminal status.  "
                    "This is a bug in your ActionServer implementation. Fix your code!  "
                    "For now, the ActionServer will set this goal to aborted"
                )
                self.set_aborted(None, "No terminal state was set.")
        except Exception as error:
            rospy.logerr("Exception in your execute callback: %s\n%s", str(error), traceback.format_exc())
            self.set_aborted(None, "Exception in execute callback: %s" % str(error))
