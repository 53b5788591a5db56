"""A relay of any type: AnyMsg in, its class from the connection header, out again, and counted."""

import rospy
import rostopic
from genpy.message import get_message_class
from std_msgs.msg import Float32MultiArray, Int8, MultiArrayDimension, String

rospy.init_node("relay")
state = {}
got = []


def on_any(msg, name):
    header = msg._connection_header
    kind = get_message_class(header["type"])
    decoded = kind().deserialize(msg._buff)
    got.append(
        (
            name,
            header["type"],
            header["md5sum"] == kind._md5sum,
            header.get("latching"),
            str(decoded).split("\n")[0],
        )
    )
    if name not in state:
        state[name] = rospy.Publisher(name + "_relayed", kind, queue_size=10, latch=True)
    state[name].publish(decoded)


sources = {
    "text": rospy.Publisher("text", String, queue_size=5, latch=True),
    "small": rospy.Publisher("small", Int8, queue_size=5),
    "array": rospy.Publisher("array", Float32MultiArray, queue_size=5),
}
subs = [rospy.Subscriber(name, rospy.AnyMsg, on_any, callback_args=name) for name in sources]
while not all(p.get_num_connections() for p in sources.values()):
    rospy.sleep(0.02)
array = Float32MultiArray(data=[1.5, 2.5])
array.layout.dim.append(MultiArrayDimension(label="x", size=2, stride=2))
for name, value in (("text", String("hello")), ("small", Int8(-5)), ("array", array)):
    sources[name].publish(value)
    while not any(g[0] == name for g in got):
        rospy.sleep(0.02)
for g in got:
    print(g)
print(
    rospy.wait_for_message("text_relayed", String, 20).data,
    rospy.wait_for_message("small_relayed", Int8, 20).data,
)
back = rospy.wait_for_message("array_relayed", Float32MultiArray, 20)
print(back.data, back.layout.dim[0].label, back._connection_header["callerid"] == rospy.get_name())
print(
    rostopic.get_topic_type(rospy.resolve_name("small"))[0],
    rostopic.get_topic_class(rospy.resolve_name("array"))[0].__name__,
)
print(
    rostopic.get_topic_type("/nowhere_at_all"),
    rostopic.get_topic_type(rospy.resolve_name("array") + "/layout/dim[0]/size")[:2],
)
function = rostopic.get_topic_class(rospy.resolve_name("array") + "/layout/dim[0]/size")[2]
print(function(array))
