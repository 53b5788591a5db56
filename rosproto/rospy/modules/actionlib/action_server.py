"""ActionServer: receives goals and cancels, publishes status, feedback and results."""

import threading

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray

from rosproto.protocol.goal_server import is_before, is_meant, next_status

from .action_client import message_classes
from .goal_id_generator import GoalIDGenerator
from .handle_tracker_deleter import HandleTrackerDeleter
from .server_goal_handle import ServerGoalHandle
from .status_tracker import StatusTracker


def nop_cb(goal_handle):
    """Does nothing."""


class ActionServer:
    """Serves any number of goals at a time; `goal_cb(handle)` decides what happens to each."""

    def __init__(self, ns, ActionSpec, goal_cb, cancel_cb=nop_cb, auto_start=True):
        self.ns = ns
        self.ActionSpec = ActionSpec
        self.ActionGoal, self.ActionResult, self.ActionFeedback = message_classes(ActionSpec)
        self.ActionResultType = type(self.ActionResult().result)
        self.goal_sub = self.cancel_sub = None
        self.status_pub = self.result_pub = self.feedback_pub = None
        self.lock = threading.RLock()
        self.status_timer = None
        self.status_list = []
        self.last_cancel = rospy.Time()
        self.status_list_timeout = rospy.Duration()
        self.id_generator = GoalIDGenerator()
        assert goal_cb
        self.goal_callback = goal_cb
        self.cancel_callback = cancel_cb
        self.auto_start = auto_start
        self.started = False
        if auto_start:
            rospy.logwarn(
                "You've passed in true for auto_start to the python action server, you should always pass "
                "in false to avoid race conditions."
            )
            self.start()

    def register_goal_callback(self, cb):
        """Call this with new goals."""
        self.goal_callback = cb

    def register_cancel_callback(self, cancel_cb):
        """Call this with goals that are to be cancelled."""
        self.cancel_callback = cancel_cb

    def start(self):
        """Begin to serve."""
        with self.lock:
            self.initialize()
            self.started = True
            self.publish_status()

    def stop(self):
        """Stop serving."""
        with self.lock:
            self.started = False
            self.status_timer.shutdown()
            for part in (
                self.goal_sub,
                self.cancel_sub,
                self.status_pub,
                self.feedback_pub,
                self.result_pub,
            ):
                part.unregister()

    def initialize(self):
        """Open the topics, start the timer of the status."""
        name = rospy.remap_name(self.ns)
        size = rospy.get_param("actionlib_server_pub_queue_size", 50)
        self.pub_queue_size = size = 50 if size < 0 else size
        self.status_pub = rospy.Publisher(name + "/status", GoalStatusArray, latch=True, queue_size=size)
        self.result_pub = rospy.Publisher(name + "/result", self.ActionResult, queue_size=size)
        self.feedback_pub = rospy.Publisher(name + "/feedback", self.ActionFeedback, queue_size=size)
        size = rospy.get_param("actionlib_server_sub_queue_size", -1)
        self.sub_queue_size = size = None if size < 0 else size
        self.goal_sub = rospy.Subscriber(
            name + "/goal", self.ActionGoal, callback=self.internal_goal_callback, queue_size=size
        )
        self.cancel_sub = rospy.Subscriber(
            name + "/cancel", GoalID, callback=self.internal_cancel_callback, queue_size=size
        )
        self.status_frequency = self._frequency(name)
        self.status_list_timeout = rospy.Duration(rospy.get_param(name + "/status_list_timeout", 5.0))
        if self.status_frequency > 0.0:
            self.status_timer = rospy.Timer(
                rospy.Duration(1.0 / self.status_frequency), self.publish_status_async
            )

    @staticmethod
    def _frequency(name):
        if rospy.has_param(name + "/status_frequency"):
            rospy.logwarn(
                "You're using the deprecated status_frequency parameter,"
                " please switch to actionlib_status_frequency."
            )
            return rospy.get_param(name + "/status_frequency", 5.0)
        found = rospy.search_param("actionlib_status_frequency")
        return 5.0 if found is None else rospy.get_param(found, 5.0)

    def publish_result(self, status, result):
        """Publish the result of a goal."""
        with self.lock:
            self._send(self.result_pub, self.ActionResult(status=status, result=result))
            self.publish_status()

    def publish_feedback(self, status, feedback):
        """Publish feedback of a goal."""
        with self.lock:
            self._send(self.feedback_pub, self.ActionFeedback(status=status, feedback=feedback))

    @staticmethod
    def _send(publisher, message):
        message.header.stamp = rospy.Time.now()
        if not rospy.is_shutdown():
            publisher.publish(message)

    def internal_cancel_callback(self, goal_id):
        """A cancel arrived: for one goal, for those up to a time, or (neither given) for all."""
        with self.lock:
            if not self.started:
                return
            found, until = False, goal_id.stamp.to_nsec()
            for tracker in self.status_list[:]:
                known = tracker.status.goal_id
                found = found or goal_id.id == known.id
                if not is_meant(known.id, known.stamp.to_nsec(), goal_id.id, until):
                    continue
                if tracker.handle_tracker is None:
                    tracker.handle_tracker = HandleTrackerDeleter(self, tracker)
                    tracker.handle_destruction_time = rospy.Time.now()
                handle = ServerGoalHandle(tracker, self, tracker.handle_tracker)
                if handle.set_cancel_requested():
                    self.cancel_callback(handle)
            if goal_id.id != "" and not found:  # the goal may arrive later
                tracker = StatusTracker(goal_id, GoalStatus.RECALLING)
                tracker.handle_destruction_time = rospy.Time.now()
                self.status_list.append(tracker)
            if goal_id.stamp > self.last_cancel:
                self.last_cancel = goal_id.stamp

    def internal_goal_callback(self, goal):
        """A goal arrived."""
        with self.lock:
            if not self.started:
                return
            for tracker in self.status_list[:]:
                if goal.goal_id.id == tracker.status.goal_id.id:
                    self._received_again(tracker)
                    return
            tracker = StatusTracker(None, None, goal)
            tracker.handle_tracker = HandleTrackerDeleter(self, tracker)
            self.status_list.append(tracker)
            handle = ServerGoalHandle(tracker, self, tracker.handle_tracker)
            if is_before(goal.goal_id.stamp.to_nsec(), self.last_cancel.to_nsec()):
                handle.set_canceled(
                    None,
                    "This goal handle was canceled by the action server because its timestamp is before the"
                    " timestamp of the last cancel request",
                )
            else:
                self.goal_callback(handle)

    def _received_again(self, tracker):
        """A goal whose id is known: its cancel arrived first, or it was sent twice."""
        if tracker.status.status == GoalStatus.RECALLING:
            tracker.status.status = int(next_status(GoalStatus.RECALLING, "cancel"))
            self.publish_result(tracker.status, self.ActionResultType())
        if tracker.handle_tracker is None:
            tracker.handle_destruction_time = rospy.Time.now()

    def publish_status_async(self, event):
        """The timer's callback."""
        with self.lock:
            if self.started:
                self.publish_status()

    def publish_status(self):
        """Publish the status of all goals; those that ended a while ago are dropped."""
        with self.lock:
            now, never = rospy.Time.now(), rospy.Time()
            self.status_list = [
                tracker
                for tracker in self.status_list
                if tracker.handle_destruction_time == never
                or tracker.handle_destruction_time + self.status_list_timeout >= now
            ]
            statuses = [tracker.status for tracker in self.status_list]
            self._send(self.status_pub, GoalStatusArray(status_list=statuses))
