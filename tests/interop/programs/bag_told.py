"""What a bag tells of itself: as text, as the YAML that programs parse, and when it is closed."""

import os
import tempfile

import rosbag
import rospy
from std_msgs.msg import Float64, String

os.chdir(tempfile.mkdtemp())
with rosbag.Bag("told.bag", "w", compression="bz2") as bag:
    for i in range(20):
        bag.write("/said", String("x" * i), rospy.Time(100 + i))
        bag.write("/number", Float64(i), rospy.Time(100 + i * 2))
    bag.write("/once", String(), rospy.Time(120))
print(bag.get_message_count(), bag.get_start_time(), bag.get_end_time())

SIZES = ("size", "compress", "uncompress")  # files of two writers
bag = rosbag.Bag("told.bag")
for text in (str(bag), bag._get_yaml_info()):
    for line in text.splitlines():
        if not line.startswith(SIZES):
            print(line)
print(bag._get_yaml_info(key="messages"), bag._get_yaml_info(key="nothing"))
bag.close()
print(bag.get_message_count("/said"), sorted(bag.get_type_and_topic_info().topics.items()))
for question in (lambda: bag.size, lambda: list(bag), lambda: rosbag.Bag("no/such/folder.bag", "w")):
    try:
        print(question())
    except (ValueError, OSError) as error:
        print(type(error).__name__, error)
