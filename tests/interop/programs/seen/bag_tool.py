# ruff: noqa: B007
"""A bag script: writes, filters by time and topic, counts, exports rows, reindexes nothing."""

import csv
import io
import os
import sys
import tempfile

import rosbag
import rospy
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Int32, String

path = os.path.join(tempfile.mkdtemp(), "run.bag")
with rosbag.Bag(path, "w", compression=rosbag.Compression.BZ2) as bag:
    for i in range(10):
        t = rospy.Time(100 + i, 500)
        pose = PoseStamped()
        pose.header.stamp, pose.header.frame_id, pose.header.seq = t, "odom", i
        pose.pose.position.x = i / 4.0
        bag.write("/pose", pose, t)
        if i % 3 == 0:
            bag.write("/count", Int32(i), t)
    bag.write("/note", String("end"), rospy.Time(120))
bag = rosbag.Bag(path)
info = bag.get_type_and_topic_info()
for topic in sorted(info.topics):
    print(
        topic, info.topics[topic].msg_type, info.topics[topic].message_count, info.topics[topic].connections
    )
print(bag.get_message_count(), bag.get_message_count("/pose"), bag.get_message_count(["/count", "/note"]))
print(bag.get_start_time(), bag.get_end_time(), os.path.basename(bag.filename), bag.mode, bag.compression)
out = io.StringIO()
writer = csv.writer(out)
for topic, msg, t in bag.read_messages(
    topics=["/pose"], start_time=rospy.Time(103), end_time=rospy.Time(105, 600)
):
    writer.writerow([t.to_nsec(), msg.header.seq, msg.header.stamp.to_sec(), msg.pose.position.x])
print(out.getvalue().split())
for topic, msg, t in bag.read_messages(topics="/note"):
    print(topic, msg.data, t, t - rospy.Time(100))
for item in bag.read_messages("/count", raw=True):
    print(item.topic, item.message[0], len(item.message[1]), item.timestamp.secs)
    break
bag.close()
with rosbag.Bag(path, "a") as bag:
    bag.write("/note", String("appended"), rospy.Time(130))
with rosbag.Bag(path) as bag:
    print(
        [m.data for _, m, _ in bag.read_messages("/note")],
        bag.get_message_count(),
        bag.get_message_count("/none"),
    )
    filtered = os.path.join(os.path.dirname(path), "filtered.bag")
    with rosbag.Bag(filtered, "w") as new:
        for topic, msg, t in bag.read_messages():
            if topic == "/pose" and msg.header.stamp.secs % 2:
                continue
            new.write(topic, msg, msg.header.stamp if msg._has_header else t)
with rosbag.Bag(filtered) as bag:
    print([(topic, t.secs) for topic, _, t in bag])
for wrong in ("/no/such.bag", __file__):
    try:
        rosbag.Bag(wrong)
    except Exception as e:
        print(type(e).__name__, str(e).split(": ")[-1][:30] if wrong[1] == "n" else "")
sys.exit(0 if os.path.getsize(filtered) else 1)
