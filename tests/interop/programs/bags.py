# ruff: noqa: B007, SIM401
"""rosbag.Bag: writing, reading, filtering, appending, raw."""

import os
import sys

import genpy
import rosbag
import rospy
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header, Int32, String

p = "%s/%d.bag" % (os.environ["ROS_HOME"], os.getpid())
b = rosbag.Bag(p, "w")
try:
    b.write("chatter", String(data="foo"), rospy.Time(10))
    b.write("numbers", Int32(42), rospy.Time(11, 500))
    b.write("/scan", LaserScan(header=Header(frame_id="l"), ranges=[1, 2.5]), rospy.Time(12))
    b.write("chatter", String("bar"), rospy.Time(12, 5))
    for i in range(5):
        b.write("/cmd", Twist(linear=Vector3(i, 0, 0)), rospy.Time(20 + i))
    b.write("/now", String("now"))
    print(b.mode, b.filename == p, b.options, b.version, b.compression, b.chunk_threshold)
    for bad in [("", String("x")), ("t", None)]:
        try:
            b.write(*bad)
            print("wrote", bad[0])
        except Exception as e:
            print(type(e).__name__, e)
finally:
    b.close()
try:
    b.write("x", String("y"))
except Exception as e:
    print(type(e).__name__, e)
b = rosbag.Bag(p)
for topic, msg, t in b.read_messages(topics=["chatter", "numbers"]):
    print(topic, msg, t, repr(t), type(t).__name__)
for m in b.read_messages(topics="/scan"):
    print(
        m.topic, m.message.ranges, m.timestamp.to_sec(), type(m).__name__, m.message._type, m.message._md5sum
    )
print(
    [m.message.linear.x for m in b.read_messages("/cmd", start_time=rospy.Time(21), end_time=genpy.Time(23))]
)
print(
    b.get_message_count(),
    b.get_message_count("chatter"),
    b.get_message_count(["chatter", "/cmd", "zz"]),
    b.get_start_time(),
)
info = b.get_type_and_topic_info()
print(info.topics["/cmd"], info.topics["chatter"], sorted(info.msg_types.items()))
print(b.get_type_and_topic_info(topic_filters="/cmd").topics, type(info).__name__, info[1].keys())
for topic, raw, t in b.read_messages(topics=["numbers"], raw=True):
    print(topic, raw[0], raw[1], raw[2], len(raw), raw[4]._type)
print(
    [
        topic
        for topic, m, t in b.read_messages(
            connection_filter=lambda topic, datatype, md5sum, msg_def, header: datatype == "std_msgs/String"
        )
    ]
)
for x in b.read_messages(topics=["numbers"], return_connection_header=True):
    print(sorted(x.connection_header), x.connection_header["type"] if "type" in x.connection_header else "")
print(len(list(b)), b.get_compression_info().compression)
b.close()
try:
    list(b.read_messages())
except Exception as e:
    print(type(e).__name__, e)
with rosbag.Bag(p, "a") as b:
    b.write("chatter", String("appended"), rospy.Time(30))
    b.write("new", Int32(1), rospy.Time(31))
with rosbag.Bag(p, "r") as b:
    print([(t, m.data) for t, m, _ in b.read_messages(["chatter", "new"])], b.get_message_count())
with rosbag.Bag(p + "o", "w", compression=rosbag.Compression.BZ2) as o:
    for topic, msg, t in rosbag.Bag(p).read_messages():
        if topic == "/cmd":
            msg.linear.x *= 2
            o.write(topic, msg, t + rospy.Duration(1))
        elif topic != "/now":
            o.write(topic, msg, msg.header.stamp if msg._has_header and msg.header.stamp else t)
print(
    [(x.topic, x.timestamp.to_sec()) for x in rosbag.Bag(p + "o")],
    rosbag.Bag(p + "o").get_compression_info().compression,
)
for f in [
    lambda: rosbag.Bag("/tmp/nope.bag"),
    lambda: rosbag.Bag(__file__),
    lambda: rosbag.Bag(p, "x"),
    lambda: rosbag.Bag(""),
    lambda: rosbag.Bag(p, compression="zip"),
    lambda: rosbag.Bag(p).write("a", String("b")),
]:
    try:
        f()
        print("ok")
    except Exception as e:
        print(type(e).__name__, isinstance(e, rosbag.ROSBagException), str(e)[:60])
msg = next(rosbag.Bag(p).read_messages("chatter")).message
print(msg == String("foo"), String("foo") == msg, msg.data == "foo", isinstance(msg, genpy.Message))
rospy.init_node("bagpub")
pub = rospy.Publisher("chatter", String, queue_size=1)
got = []
s = rospy.Subscriber("chatter", String, lambda m: got.append(m.data))
while not pub.get_num_connections():
    rospy.sleep(0.05)
pub.publish(msg)
while not got:
    rospy.sleep(0.01)
print(got)
for q in (p, p + "o"):
    os.remove(q)
