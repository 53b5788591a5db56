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
        print("accepted", g.goal)
        self.n = g.goal

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
# wait_for_server() looks at this side only: what goes out before the server knows of its listener is lost.
while not all(
    p.get_num_connections() for p in (s.s.action_server.result_pub, s.s.action_server.feedback_pub)
):
    rospy.sleep(0.01)


def send(n):
    """Send a goal. The server looks at it when the client knows its handle: earlier answers would be lost."""
    with s.s.action_server.lock:
        c.send_goal(TestGoal(n))


def active():
    """Wait until the server has printed that it pursues the long goal, and the client knows it."""
    while c.get_state() != 1 or s.n is None or s.n < 1000:
        rospy.sleep(0.01)


for n, w in [(2, 20), (5000, 0.3), (3, 20)]:
    send(n)
    if n == 5000:
        active()
    print(c.wait_for_result(rospy.Duration(w)), c.get_state(), c.get_result())
send(5000)
active()
c.cancel_goal()
print(c.wait_for_result(rospy.Duration(20)), c.get_state(), c.get_goal_status_text())
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
for server in (s.s, a):
    with server.action_server.lock:
        server.action_server.started = False  # or its timer may publish while the topics are closed
rospy.signal_shutdown("done")
