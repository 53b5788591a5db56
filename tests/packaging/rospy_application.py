"""A program written for rospy, with one line on top; check.py freezes it, as it does application.py."""

# ruff: noqa: I001
import os

import rosproto.rospy.install  # noqa: F401

import actionlib
import rospy
import tf.transformations
from actionlib.msg import TestAction, TestGoal, TestResult
from std_msgs.msg import String
from std_srvs.srv import SetBool, SetBoolResponse

from rosproto import Master

with Master() as master:
    os.environ["ROS_MASTER_URI"] = master.uri
    rospy.init_node("frozen")
    words = rospy.Publisher("/words", String, queue_size=1, latch=True)
    words.publish("said")
    print("topic:", rospy.wait_for_message("/words", String, 20).data)
    rospy.Service("/set", SetBool, lambda request: SetBoolResponse(request.data, "done"))
    print("service:", rospy.ServiceProxy("/set", SetBool)(True).message)
    server = actionlib.SimpleActionServer(
        "/act", TestAction, lambda goal: server.set_succeeded(TestResult(goal.goal)), auto_start=False
    )
    server.start()
    client = actionlib.SimpleActionClient("/act", TestAction)
    assert client.wait_for_server(rospy.Duration(20))
    client.send_goal_and_wait(TestGoal(7))
    print("action:", client.get_result().result)
    rospy.set_param("/p", {"a": [1, 2.5]})
    print("parameter:", rospy.get_param("/p/a"), tf.transformations.quaternion_from_euler(0, 0, 0)[3])
    rospy.signal_shutdown("done")
