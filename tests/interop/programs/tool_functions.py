"""What programs use of rostopic, rosnode, rosmsg, roslib and actionlib beside the common functions."""

import os
import sys
import time
import warnings

import actionlib
import roslib.names
import roslib.scriptutil
import rosmsg
import rosnode
import rospkg
import rospy
import rostopic
from actionlib_msgs.msg import GoalID
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from rosgraph_msgs.msg import Log
from std_msgs.msg import Header, String, UInt8MultiArray

warnings.simplefilter("ignore")  # some of it is deprecated, which ours does not say
import roslib.rosenv  # noqa: E402

rospy.init_node("tools", disable_rosout=True)
for echo, topic, message in (
    (rostopic.CallbackEcho("/a", None), "/a", String("x")),
    (rostopic.CallbackEcho("/a/", None, count=1), "/a", String("x")),
    (rostopic.CallbackEcho("/a", None, count=2, echo_all_topics=True), "/b", String("y")),
    (rostopic.CallbackEcho("/a", None), "/b", String("not printed")),
    (rostopic.CallbackEcho("/a/data", None), "/a", String("field")),
    (rostopic.CallbackEcho("/a", None, filter_fn=lambda m: m.data != "x"), "/a", String("x")),
    (rostopic.CallbackEcho("/a", None, fixed_numeric_width=6), "/a", UInt8MultiArray(data=b"\x01\x02")),
    (rostopic.CallbackEcho("/a", None, field_filter_fn=lambda m: ["frame_id"]), "/a", Header(frame_id="f")),
    (rostopic.CallbackEcho("/a", None, echo_clear=True), "/a", Log(msg="m")),
):
    echo.callback(message, {"topic": topic})
    echo.callback(message, {"topic": topic})
    print(echo.done, echo.count)
publisher = rospy.Publisher("/out", String, queue_size=3)
before = time.time()
rostopic.wait_for_subscriber(publisher, 0.2)
print(0.2 <= time.time() - before < 5)
rospy.Subscriber("/out", String, lambda m: print("heard", m.data))
rostopic.wait_for_subscriber(publisher, 20)
rostopic.publish_message(publisher, String, ["word"], once=True)
time.sleep(0.3)
for arguments in ([1, 2], [3]):
    try:
        rostopic.publish_message(publisher, String, arguments, once=True, verbose=True)
    except rostopic.ROSTopicException as error:
        print(str(error).partition("\n\nmsg file")[0])
try:
    rostopic.publish_message(publisher, String, ["x"], rate="fast")
except rostopic.ROSTopicException as error:
    print(error)
print(rosmsg.MODE_MSG, rosmsg.MODE_SRV, rosmsg.rosmsg_md5(rosmsg.MODE_MSG, "std_msgs/String"))
for mode, name in ((rosmsg.MODE_MSG, "std_msgs/None"), (rosmsg.MODE_SRV, "roscpp/Empty")):
    try:
        print(rosmsg.rosmsg_md5(mode, name))
    except OSError as error:
        print(error)
print(sorted(rosmsg.list_types("roscpp", rosmsg.MODE_SRV)))
for mode in (rosmsg.MODE_MSG, rosmsg.MODE_SRV):
    folders = dict(rosmsg.iterate_packages(rospkg.RosPack(), mode))
    print("std_msgs" in folders, "roscpp" in folders, mode)
    print([os.path.isfile(os.path.join(folders["roscpp"], name)) for name in ("Logger.msg", "Empty.srv")])
print([os.path.basename(path) for path in rosmsg._get_package_paths("std_msgs", rospkg.RosPack())])
print(rostopic._get_topic_type("/out")[:2], rostopic._get_topic_type("/nothing"))
rosnode.rosnode_cleanup()
print(roslib.names.ns_join("a", "b"), roslib.rosenv.get_master_uri().startswith("http://"))
print(roslib.scriptutil.get_master().getPid("/x")[:1], roslib.scriptutil.script_resolve_name("s", "n"))
for call in (roslib.rosenv.get_ros_package_path, roslib.rosenv.get_ros_root):
    try:
        call(True, {})
    except roslib.rosenv.ROSEnvException as error:
        print(type(error).__name__)
manager = actionlib.GoalManager(MoveBaseAction)
manager.register_send_goal_fn(lambda goal: print("sent", type(goal).__name__))
manager.register_cancel_fn(lambda goal_id: print("cancel", type(goal_id) is GoalID))
handle = manager.init_goal(MoveBaseGoal())
handle.cancel()
print(handle.get_comm_state(), manager.ActionResult.__name__)
sys.stdout.flush()
