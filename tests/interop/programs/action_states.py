"""Everything that a simple action client and server do with goals."""

import threading

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
        for i in range(goal.goal):
            if self.s.is_preempt_requested() or rospy.is_shutdown():
                self.s.set_preempted(TestResult(i * 0), "stopped")
                return
            if i < 2:
                self.s.publish_feedback(TestFeedback(i))
            rospy.sleep(0.1)
        self.s.set_succeeded(TestResult(goal.goal), "counted")


srv = Server()
c = actionlib.SimpleActionClient("count", TestAction)
print(c.get_state(), c.get_result(), repr(c.get_goal_status_text()))
print(c.wait_for_result(rospy.Duration(0.1)))
print(actionlib.SimpleActionClient("absent", TestAction).wait_for_server(rospy.Duration(0.3)))
print(c.wait_for_server(rospy.Duration(5)), c.wait_for_server(timeout=rospy.Duration(1)))


def run(n, cancel=None, **kw):
    c.send_goal(TestGoal(n), **kw)
    if cancel:
        rospy.sleep(cancel)
        c.cancel_goal()
    print(
        "W",
        c.wait_for_result(rospy.Duration(5)),
        c.get_state(),
        GoalStatus.to_string(c.get_state()) if hasattr(GoalStatus, "to_string") else "",
        repr(c.get_goal_status_text()),
    )
    print(c.get_result())


told = []
run(
    3,
    done_cb=lambda s, r: told.append(("done", s, r.result)),
    active_cb=lambda: told.append("active"),
    feedback_cb=lambda f: told.append(f.feedback),
)
print(told)
run(-1)
run(-2)
run(-3)
run(-4)
run(50, 0.4, done_cb=lambda s, r: print("D", s, r.result))
print(
    c.send_goal_and_wait(TestGoal(2)), c.send_goal_and_wait(TestGoal(2), rospy.Duration(5), rospy.Duration(1))
)
print(c.send_goal_and_wait(TestGoal(50), rospy.Duration(0.3), rospy.Duration(2)), c.get_state())
c.send_goal(TestGoal(30))
rospy.sleep(0.3)
print(c.get_state(), c.simple_state, actionlib.SimpleGoalState.to_string(c.simple_state))
print(c.wait_for_result(rospy.Duration(0.2)))
c.send_goal(TestGoal(1))
print(c.wait_for_result(rospy.Duration(5)), c.get_state())
c.send_goal(TestGoal(40))
rospy.sleep(0.3)
c.cancel_all_goals()
print(c.wait_for_result(rospy.Duration(3)), c.get_state())
c.send_goal(TestGoal(40))
rospy.sleep(0.3)
c.stop_tracking_goal()
print(c.get_state())
print(c.wait_for_result(rospy.Duration(0.2)))
c.cancel_all_goals()
rospy.sleep(0.5)
c.send_goal(TestGoal(40))
rospy.sleep(0.2)
c.cancel_goals_at_and_before_time(rospy.Time.now())
print(c.wait_for_result(rospy.Duration(3)), c.get_state())
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
rospy.signal_shutdown("done")
