# ruff: noqa: F403, F405
"""A simple action server with goal and preempt callbacks."""

import actionlib
import rospy
from actionlib.msg import *

rospy.init_node("gc")


class S:
    def __init__(self):
        self.s = actionlib.SimpleActionServer("gc", TestAction, auto_start=False)
        self.s.register_goal_callback(self.goal)
        self.s.register_preempt_callback(self.pre)
        self.s.start()
        self.t = rospy.Timer(rospy.Duration(0.1), self.tick)
        self.n = None

    def goal(self):
        g = self.s.accept_new_goal()
        self.n = g.goal
        print("accepted", g.goal)

    def pre(self):
        print("preempt", self.s.is_new_goal_available())
        if not self.s.is_new_goal_available():
            self.s.set_preempted(text="p")
            self.n = None

    def tick(self, e):
        if self.n is None or not self.s.is_active():
            return
        self.n -= 1
        if self.n <= 0:
            self.n = None
            self.s.set_succeeded(TestResult(7))


s = S()
c = actionlib.SimpleActionClient("/gc", TestAction)
c.wait_for_server()
for n, w in [(2, 5), (50, 0.3), (3, 5)]:
    c.send_goal(TestGoal(n))
    print(c.wait_for_result(rospy.Duration(w)), c.get_state(), c.get_result())
c.send_goal(TestGoal(50))
rospy.sleep(0.3)
c.cancel_goal()
print(c.wait_for_result(rospy.Duration(3)), c.get_state(), c.get_goal_status_text())
try:
    s.s.accept_new_goal()
except Exception as e:
    print(type(e), e)
try:
    s.s.set_succeeded(TestResult(1))
    print("done twice")
except Exception as e:
    print(type(e), e)
a = actionlib.SimpleActionServer("auto", TestAction, lambda g: None)
try:
    actionlib.SimpleActionServer("both", TestAction, lambda g: None, False).register_goal_callback(print)
except Exception as e:
    print(type(e), e)
b = actionlib.SimpleActionServer("notstarted", TestAction, lambda g: None, False)
print(b.is_active(), b.is_preempt_requested(), b.get_default_result())
rospy.signal_shutdown("done")
