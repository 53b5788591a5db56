"""A robot of real rospy, for web clients to talk with; runs where rospy is (Debian's /usr/bin/python3).

Publishes /chatter, /kept (latched), /scan and /picture; says on /heard what came on /to_robot; provides /lamp,
/ask (which calls the service named in the parameter /ask_whom) and the action /walk; sends tf; prints "ready".
"""

import actionlib
import rospy
from actionlib.msg import TestAction, TestFeedback, TestResult
from geometry_msgs.msg import TransformStamped, Twist
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import String
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse
from tf2_msgs.msg import TFMessage


def main() -> None:
    rospy.init_node("robot")
    topics = {
        "/chatter": rospy.Publisher("/chatter", String, queue_size=10),
        "/scan": rospy.Publisher("/scan", LaserScan, queue_size=10),
        "/picture": rospy.Publisher("/picture", Image, queue_size=10),
        "/tf": rospy.Publisher("/tf", TFMessage, queue_size=10),
    }
    rospy.Publisher("/kept", String, latch=True, queue_size=1).publish("kept äöü 地图")
    heard = rospy.Publisher("/heard", String, queue_size=10)
    rospy.Subscriber("/to_robot", String, lambda m: heard.publish(m.data + "!"))
    rospy.Subscriber("/cmd_vel", Twist, lambda m: heard.publish(f"{m.linear.x} {m.angular.z}"))
    rospy.Service("/lamp", SetBool, lamp)
    rospy.Service("/ask", Trigger, ask)
    server = actionlib.SimpleActionServer(
        "/walk", TestAction, lambda goal: walk(server, goal), auto_start=False
    )
    server.start()
    count = 0
    timer = rospy.Timer(rospy.Duration(0.05), lambda _: say(topics, count))
    print("ready", flush=True)
    rospy.spin()
    timer.shutdown()


def say(topics, count) -> None:
    topics["/chatter"].publish("hello")
    scan = LaserScan(ranges=[0.5, float("nan"), float("inf"), 2.0], angle_min=-1.5)
    scan.header.frame_id = "laser"
    topics["/scan"].publish(scan)
    topics["/picture"].publish(Image(height=2, width=3, encoding="rgb8", step=9, data=bytes(range(18))))
    transform = TransformStamped()
    transform.header.frame_id, transform.child_frame_id = "map", "base_link"
    transform.header.stamp = rospy.get_rostime()
    transform.transform.translation.x, transform.transform.rotation.w = 1.5, 1.0
    topics["/tf"].publish([transform])


def lamp(request):
    if not request.data:
        raise rospy.ServiceException("the lamp is broken")
    return SetBoolResponse(True, "on")


def ask(_):
    whom = rospy.ServiceProxy(rospy.get_param("/ask_whom"), SetBool)
    try:
        return TriggerResponse(True, whom(True).message)
    except rospy.ServiceException as error:
        return TriggerResponse(False, str(error))


def walk(server, goal) -> None:
    server.publish_feedback(TestFeedback(goal.goal))
    while goal.goal < 0:  # until it is cancelled
        if server.is_preempt_requested():
            server.set_preempted(TestResult(-1), "as you wish")
            return
        rospy.sleep(0.01)
    if goal.goal > 100:
        server.set_aborted(TestResult(0), "too far")
        return
    server.set_succeeded(TestResult(goal.goal * 2), "well")


if __name__ == "__main__":
    main()
