# ruff: noqa: B023
"""move_base as clients use it: goals, feedback, time-outs, cancelling, texts; the server is in the program."""

import threading

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Pose, Quaternion
from move_base_msgs.msg import MoveBaseAction, MoveBaseFeedback, MoveBaseGoal, MoveBaseResult

rospy.init_node("nav_test")


def until(condition):
    while not condition():
        rospy.sleep(0.005)


def execute(goal):
    x = goal.target_pose.pose.position.x
    until(lambda: client.simple_state != actionlib.SimpleGoalState.PENDING)
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
        if x < 30:
            until(lambda: not watched or step in steps)  # the result is another topic, and may overtake
        rospy.sleep(0.02)
    server.set_succeeded(MoveBaseResult(), "Goal reached.")


server = actionlib.SimpleActionServer("move_base", MoveBaseAction, execute, auto_start=False)
server.start()


class Client(actionlib.SimpleActionClient):
    def send_goal(self, *args, **kw):
        """The server looks at a goal when the client knows its handle: rospy loses what is earlier."""
        with server.action_server.lock:
            actionlib.SimpleActionClient.send_goal(self, *args, **kw)

    def wait_for_result(self, *args, **kw):
        """The time that a goal has begins when it is pursued: a cancel may overtake a goal."""
        until(lambda: self.simple_state != actionlib.SimpleGoalState.PENDING)
        return actionlib.SimpleActionClient.wait_for_result(self, *args, **kw)


watched, steps = True, []
client = Client("move_base", MoveBaseAction)
print("server:", client.wait_for_server(rospy.Duration(20)))
# wait_for_server() looks at this side only: what goes out before the server knows of its listener is lost.
while not all(
    p.get_num_connections() for p in (server.action_server.result_pub, server.action_server.feedback_pub)
):
    rospy.sleep(0.01)
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


for x, timeout in ((2, 20), (-1, 20), (3000, 0.35), (0, 20)):
    done, steps = [], []
    client.send_goal(
        make(x),
        done_cb=lambda state, result: done.append((names[state], type(result).__name__)),
        active_cb=lambda: steps.append("active"),
        feedback_cb=lambda f: steps.append(f.base_position.pose.position.x),
    )
    if x == 3000:
        until(lambda: len(steps) >= 2)
    finished = client.wait_for_result(rospy.Duration(timeout))
    if not finished:
        print("Timed out, cancelling", names[client.get_state()], len(steps) >= 2)
        client.cancel_goal()
        print(client.wait_for_result(rospy.Duration(20)))
        steps = steps[:2]
    print(x, names[client.get_state()], repr(client.get_goal_status_text()), done, steps)
watched = False
print(client.send_goal_and_wait(make(1)), client.simple_state)


def cancel_soon():
    until(
        lambda: (
            client.simple_state == actionlib.SimpleGoalState.ACTIVE
            and client.get_state() == GoalStatus.ACTIVE
        )
    )
    client.cancel_all_goals()


threading.Thread(target=cancel_soon).start()
print(names[client.send_goal_and_wait(make(3000), rospy.Duration(20), rospy.Duration(20))])
print(
    names[
        client.send_goal_and_wait(
            make(3000), execute_timeout=rospy.Duration(0.2), preempt_timeout=rospy.Duration(20)
        )
    ]
)
client.stop_tracking_goal()
client.cancel_goal()
print(GoalStatus.SUCCEEDED, names[client.get_state()], client.get_result())
other = actionlib.SimpleActionClient("nobody", MoveBaseAction)
print(other.wait_for_server(rospy.Duration(0.2)))
with server.action_server.lock:
    server.action_server.started = False  # or its timer may publish while the topics are closed
rospy.signal_shutdown("done")  # the server's thread would go on
