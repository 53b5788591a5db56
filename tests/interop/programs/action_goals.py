# ruff: noqa: B023, F403, F405
"""ActionClient and ActionServer: goal handles, transitions, texts."""

import time

import actionlib
import rospy
from actionlib.msg import *
from actionlib_msgs.msg import *

rospy.init_node("ac")
log = []


def until(seen):
    """Wait for what the client notes: feedback, status and result are topics of their own, in no common order."""
    while not any(seen(*entry) for entry in log):
        time.sleep(0.005)


def goal_cb(gh):
    g = gh.get_goal()
    print("S", g.goal, gh.get_goal_status().status, len(gh.get_goal_id().id) > 5)
    if g.goal == 0:
        gh.set_rejected(TestResult(0), "no zeros")
        return
    gh.set_accepted("ok")
    until(lambda state, _: state == actionlib.CommState.ACTIVE)
    for i in range(2):
        gh.publish_feedback(TestFeedback(i))
        until(lambda what, number: what == "fb" and number == i)
    if g.goal == 1:
        gh.set_succeeded(TestResult(1), "one")
    elif g.goal == 2:
        gh.set_aborted(TestResult(2), "two")


def cancel_cb(gh):
    print("S cancel", gh.get_goal_status().status)
    until(lambda state, _: state == actionlib.CommState.PREEMPTING)
    gh.set_canceled(TestResult(9), "cancelled")


s = actionlib.ActionServer("raw", TestAction, goal_cb, cancel_cb, auto_start=False)
s.start()
c = actionlib.ActionClient("raw", TestAction)
print(c.wait_for_server(rospy.Duration(20)))
# wait_for_server() looks at this side only: what goes out before the server knows of its listener is lost.
while not all(p.get_num_connections() for p in (s.result_pub, s.feedback_pub)):
    rospy.sleep(0.01)


def tr(gh):
    log.append((gh.get_comm_state(), gh.get_goal_status()))


def fb(gh, f):
    log.append(("fb", f.feedback))


for n in [0, 1, 2, 3]:
    del log[:]
    gh = c.send_goal(TestGoal(n), transition_cb=tr, feedback_cb=fb)
    if n == 3:
        until(lambda what, number: what == "fb" and number == 1)
        gh.cancel()
    until(lambda state, _: state == actionlib.CommState.DONE)
    print(log)
    print(
        gh.get_comm_state(),
        actionlib.CommState.to_string(gh.get_comm_state()),
        gh.get_goal_status(),
        gh.get_goal_status_text(),
        gh.get_result(),
        gh.get_terminal_state() if gh.get_comm_state() == actionlib.CommState.DONE else None,
    )
del log[:]
with s.lock:  # the server has not looked at it yet
    last = c.send_goal(TestGoal(1), transition_cb=tr, feedback_cb=fb)
    print(last.get_terminal_state())
until(lambda state, _: state == actionlib.CommState.DONE)
print(gh == gh, gh != gh, hash(gh) is not None)
with s.lock:
    s.started = False  # or its timer may publish while the topics are closed
