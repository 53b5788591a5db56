# ruff: noqa: B023
"""move_base as clients use it: goals, feedback, time-outs, cancelling, texts; the server is in the program."""

import threading

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Pose, Quaternion
from move_base_msgs.msg import MoveBaseAction, MoveBaseFeedback, MoveBaseGoal, MoveBaseResult

rospy.init_node("nav_test")


def execute(goal):
    x = goal.target_pose.pose.position.x
    rospy.sleep(0.2)  # rospy's client may miss the state of a goal that is active for less
    feedback = MoveBaseFeedback()
    feedback.base_position.header.frame_id = goal.target_pose.header.frame_id
    if x < 0:
        server.set_aborted(MoveBaseResult(), "Failed to find a valid plan.")
        return
    for step in range(int(x)):
        if server.is_preempt_requested():
            server.set_preempted(text="stopped")
            return
        feedback.base_position.pose.position.x = step
        server.publish_feedback(feedback)
        rospy.sleep(0.1)
    server.set_succeeded(MoveBaseResult(), "Goal reached.")


server = actionlib.SimpleActionServer("move_base", MoveBaseAction, execute, auto_start=False)
server.start()
client = actionlib.SimpleActionClient("move_base", MoveBaseAction)
print("server:", client.wait_for_server(rospy.Duration(10)))
names = [
    "PENDING",
    "ACTIVE",
    "PREEMPTED",
    "SUCCEEDED",
    "ABORTED",
    "REJECTED",
    "PREEMPTING",
    "RECALLING",
    "RECALLED",
    "LOST",
]


def make(x):
    goal = MoveBaseGoal()
    goal.target_pose.header.frame_id = "map"
    goal.target_pose.header.stamp = rospy.Time.now()
    goal.target_pose.pose = Pose(Point(x, 0, 0), Quaternion(0, 0, 0, 1))
    return goal


for x, timeout in ((2, 5), (-1, 5), (30, 0.35), (0, 5)):
    done, steps = [], []
    client.send_goal(
        make(x),
        done_cb=lambda state, result: done.append((names[state], type(result).__name__)),
        active_cb=lambda: steps.append("active"),
        feedback_cb=lambda f: steps.append(f.base_position.pose.position.x),
    )
    finished = client.wait_for_result(rospy.Duration(timeout))
    if not finished:
        print("Timed out, cancelling", names[client.get_state()], len(steps) >= 2)
        client.cancel_goal()
        print(client.wait_for_result(rospy.Duration(5)))
        steps = steps[:2]
    print(x, names[client.get_state()], repr(client.get_goal_status_text()), done, steps)
print(client.send_goal_and_wait(make(1)), client.simple_state)
threading.Timer(0.3, client.cancel_all_goals).start()
print(names[client.send_goal_and_wait(make(30), rospy.Duration(10), rospy.Duration(5))])
print(
    names[
        client.send_goal_and_wait(
            make(30), execute_timeout=rospy.Duration(0.2), preempt_timeout=rospy.Duration(5)
        )
    ]
)
client.stop_tracking_goal()
client.cancel_goal()
print(GoalStatus.SUCCEEDED, names[client.get_state()], client.get_result())
other = actionlib.SimpleActionClient("nobody", MoveBaseAction)
print(other.wait_for_server(rospy.Duration(0.2)))
rospy.signal_shutdown("done")  # the server's thread would go on
