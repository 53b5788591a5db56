"""SimpleActionClient: order of callbacks, states, cancelling, time-outs."""

import actionlib
import rospy
from actionlib.msg import TestAction, TestGoal

rospy.init_node("action_client")


class Client(actionlib.SimpleActionClient):
    def wait_for_result(self, *args, **kw):
        """The time that a goal has begins when it is pursued: a cancel may overtake a goal."""
        while self.gh and self.get_state() == actionlib.GoalStatus.PENDING:
            rospy.sleep(0.005)
        return actionlib.SimpleActionClient.wait_for_result(self, *args, **kw)


client = Client("/count", TestAction)
print(client.get_state() == actionlib.GoalStatus.LOST, client.wait_for_result())
print(client.wait_for_server(rospy.Duration(10)))
events, active = [], []


def send(goal, **callbacks):
    """The server begins when the client knows the handle: rospy loses what comes earlier."""
    client.send_goal(goal, **callbacks)
    rospy.set_param("/sent", goal.goal)


def hear(feedback):
    events.append(feedback.feedback)
    rospy.set_param("/seen", feedback.feedback)  # the result is another topic, and may overtake


send(
    TestGoal(goal=3),
    done_cb=lambda status, result: events.append(("done", status, result.result)),
    active_cb=lambda: active.append("active"),
    feedback_cb=hear,
)
print(client.wait_for_result(rospy.Duration(20)), events, client.get_state(), client.get_result().result)
print(
    client.get_goal_status_text(), active in ([], ["active"])
)  # lost when it comes before send_goal() returns
send(TestGoal(goal=-1))
print(
    client.wait_for_result(),
    client.get_state() == actionlib.GoalStatus.ABORTED,
    client.get_goal_status_text(),
)
send(TestGoal(goal=1000))
print(client.wait_for_result(rospy.Duration(0.3)), client.get_state())
client.cancel_goal()
print(client.wait_for_result(rospy.Duration(20)), client.get_state() == actionlib.GoalStatus.PREEMPTED)
print(client.send_goal_and_wait(TestGoal(goal=1000), rospy.Duration(0.3), rospy.Duration(20)))
print(actionlib.SimpleActionClient("/nobody", TestAction).wait_for_server(rospy.Duration(0.4)))
