"""SimpleActionClient: order of callbacks, states, cancelling, time-outs."""

import actionlib
import rospy
from actionlib.msg import TestAction, TestGoal

rospy.init_node("action_client")
client = actionlib.SimpleActionClient("/count", TestAction)
print(client.get_state() == actionlib.GoalStatus.LOST, client.wait_for_result())
print(client.wait_for_server(rospy.Duration(10)))
events = []
client.send_goal(
    TestGoal(goal=3),
    done_cb=lambda status, result: events.append(("done", status, result.result)),
    active_cb=lambda: events.append("active"),
    feedback_cb=lambda feedback: events.append(feedback.feedback),
)
print(client.wait_for_result(rospy.Duration(10)), events, client.get_state(), client.get_result().result)
print(client.get_goal_status_text())
client.send_goal(TestGoal(goal=-1))
print(
    client.wait_for_result(),
    client.get_state() == actionlib.GoalStatus.ABORTED,
    client.get_goal_status_text(),
)
client.send_goal(TestGoal(goal=1000))
print(client.wait_for_result(rospy.Duration(0.5)), client.get_state())
client.cancel_goal()
print(client.wait_for_result(rospy.Duration(10)), client.get_state() == actionlib.GoalStatus.PREEMPTED)
print(client.send_goal_and_wait(TestGoal(goal=1000), rospy.Duration(0.3), rospy.Duration(5)))
print(actionlib.SimpleActionClient("/nobody", TestAction).wait_for_server(rospy.Duration(0.4)))
