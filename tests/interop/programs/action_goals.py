# ruff: noqa: F403, F405
"""ActionClient and ActionServer: goal handles, transitions, texts."""

import time

import actionlib
import rospy
from actionlib.msg import *
from actionlib_msgs.msg import *

rospy.init_node("ac")
log = []


def goal_cb(gh):
    g = gh.get_goal()
    print("S", g.goal, gh.get_goal_status().status, len(gh.get_goal_id().id) > 5)
    if g.goal == 0:
        gh.set_rejected(TestResult(0), "no zeros")
        return
    gh.set_accepted("ok")
    for i in range(2):
        gh.publish_feedback(TestFeedback(i))
        rospy.sleep(0.05)
    if g.goal == 1:
        gh.set_succeeded(TestResult(1), "one")
    elif g.goal == 2:
        gh.set_aborted(TestResult(2), "two")


def cancel_cb(gh):
    print("S cancel", gh.get_goal_status().status)
    gh.set_canceled(TestResult(9), "cancelled")


s = actionlib.ActionServer("raw", TestAction, goal_cb, cancel_cb, auto_start=False)
s.start()
c = actionlib.ActionClient("raw", TestAction)
print(c.wait_for_server(rospy.Duration(5)))


def tr(gh):
    log.append((gh.get_comm_state(), gh.get_goal_status()))


def fb(gh, f):
    log.append(("fb", f.feedback))


for n in [0, 1, 2, 3]:
    del log[:]
    gh = c.send_goal(TestGoal(n), transition_cb=tr, feedback_cb=fb)
    rospy.sleep(0.6)
    if n == 3:
        gh.cancel()
        rospy.sleep(0.5)
    print(log)
    print(
        gh.get_comm_state(),
        actionlib.CommState.to_string(gh.get_comm_state()),
        gh.get_goal_status(),
        gh.get_goal_status_text(),
        gh.get_result(),
        gh.get_terminal_state() if gh.get_comm_state() == actionlib.CommState.DONE else None,
    )
try:
    state = c.send_goal(TestGoal(1)).get_terminal_state()
    rospy.sleep(0.3)  # the server prints too
    print(state)
except Exception as e:
    print(type(e), e)
rospy.sleep(0.5)
print(gh == gh, gh != gh, hash(gh) is not None)
