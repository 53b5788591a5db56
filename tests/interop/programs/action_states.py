"""Everything that a simple action client and server do with goals."""

import time

import actionlib
import rospy
from actionlib.msg import TestAction, TestFeedback, TestGoal, TestResult
from actionlib_msgs.msg import GoalStatus

rospy.init_node("act")


class Server(object):
    def __init__(self):
        self.s = actionlib.SimpleActionServer("count", TestAction, execute_cb=self.go, auto_start=False)
        self.s.register_preempt_callback(lambda: print("S preempt"))
        self.s.start()

    def go(self, goal):
        print(
            "S goal",
            goal.goal,
            self.s.is_active(),
            self.s.is_new_goal_available(),
            self.s.is_preempt_requested(),
        )
        begun.append(goal.goal)
        if goal.goal == -1:
            self.s.set_aborted(TestResult(-1), "neg")
            return
        if goal.goal == -2:
            return
        if goal.goal == -3:
            raise ValueError("in execute")
        if goal.goal == -4:
            self.s.set_succeeded()
            return
        # Status, feedback and result are topics of their own: one waits until the client has heard of the one before.
        while c.simple_state == actionlib.SimpleGoalState.PENDING:
            time.sleep(0.005)
        for i in range(goal.goal):
            if self.s.is_preempt_requested() or rospy.is_shutdown():
                self.s.set_preempted(TestResult(i * 0), "stopped")
                return
            if i < 2:
                self.s.publish_feedback(TestFeedback(i))
                while watched and i not in told:
                    time.sleep(0.005)
            rospy.sleep(0.05)
        self.s.set_succeeded(TestResult(goal.goal), "counted")


class Client(actionlib.SimpleActionClient):
    def send_goal(self, *args, **kw):
        """The server looks at a goal when the client knows its handle: earlier answers would be lost."""
        sent.append(args)
        with srv.s.action_server.lock:
            actionlib.SimpleActionClient.send_goal(self, *args, **kw)

    def wait_for_result(self, *args, **kw):
        """The time that a goal has begins when it is pursued: a cancel may overtake a goal."""
        while self.gh and self.simple_state == actionlib.SimpleGoalState.PENDING:
            time.sleep(0.005)
        return actionlib.SimpleActionClient.wait_for_result(self, *args, **kw)


told, sent, begun = [], [], []
watched = False
srv = Server()
c = Client("count", TestAction)
print(c.get_state(), c.get_result(), repr(c.get_goal_status_text()))
print(c.wait_for_result(rospy.Duration(0.1)))
print(actionlib.SimpleActionClient("absent", TestAction).wait_for_server(rospy.Duration(0.3)))
print(c.wait_for_server(rospy.Duration(20)), c.wait_for_server(timeout=rospy.Duration(1)))
# wait_for_server() looks at this side only: what goes out before the server knows of its listener is lost.
while not all(
    p.get_num_connections() for p in (srv.s.action_server.result_pub, srv.s.action_server.feedback_pub)
):
    rospy.sleep(0.01)


def active():
    """Wait until the server has printed that it pursues the goal, and the client knows it."""
    while c.simple_state != actionlib.SimpleGoalState.ACTIVE or len(begun) < len(sent):
        rospy.sleep(0.01)


def run(n, cancel=False, **kw):
    c.send_goal(TestGoal(n), **kw)
    if cancel:
        active()
        c.cancel_goal()
    print(
        "W",
        c.wait_for_result(rospy.Duration(20)),
        c.get_state(),
        GoalStatus.to_string(c.get_state()) if hasattr(GoalStatus, "to_string") else "",
        repr(c.get_goal_status_text()),
    )
    print(c.get_result())


watched = True
run(
    3,
    done_cb=lambda s, r: told.append(("done", s, r.result)),
    active_cb=lambda: told.append("active"),
    feedback_cb=lambda f: told.append(f.feedback),
)
print(told)
watched = False
run(-1)
run(-2)
run(-3)
run(-4)
run(5000, cancel=True, done_cb=lambda s, r: print("D", s, r.result))
print(
    c.send_goal_and_wait(TestGoal(2)),
    c.send_goal_and_wait(TestGoal(2), rospy.Duration(20), rospy.Duration(1)),
)
print(c.send_goal_and_wait(TestGoal(5000), rospy.Duration(0.3), rospy.Duration(20)), c.get_state())
c.send_goal(TestGoal(5000))
active()
print(c.get_state(), c.simple_state, actionlib.SimpleGoalState.to_string(c.simple_state))
print(c.wait_for_result(rospy.Duration(0.2)))
c.send_goal(TestGoal(1))
print(c.wait_for_result(rospy.Duration(20)), c.get_state())
c.send_goal(TestGoal(5000))
active()
c.cancel_all_goals()
print(c.wait_for_result(rospy.Duration(20)), c.get_state())
c.send_goal(TestGoal(5000))
active()
c.stop_tracking_goal()
print(c.get_state())
print(c.wait_for_result(rospy.Duration(0.2)))
c.cancel_all_goals()
while srv.s.is_active():
    rospy.sleep(0.01)
c.send_goal(TestGoal(5000))
active()
c.cancel_goals_at_and_before_time(rospy.Time.now())
print(c.wait_for_result(rospy.Duration(20)), c.get_state())
try:
    c.send_goal(5)
except Exception as e:
    print(type(e).__name__, e)
try:
    c.send_goal(TestResult())
except Exception as e:
    print(type(e).__name__, e)
try:
    actionlib.SimpleActionClient("x", TestGoal)
except Exception as e:
    print(type(e).__name__, e)
try:
    actionlib.SimpleActionServer("y", TestGoal, None, False)
except Exception as e:
    print(type(e).__name__, e)
print(
    [k for k in dir(GoalStatus) if k.isupper()],
    actionlib.get_name_of_constant(GoalStatus, 3) if hasattr(actionlib, "get_name_of_constant") else "",
    actionlib.CommState.to_string(2),
    actionlib.TerminalState.to_string(3),
)
with srv.s.action_server.lock:
    srv.s.action_server.started = False  # or its timer may publish while the topics are closed
rospy.signal_shutdown("done")
