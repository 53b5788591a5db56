# ruff: noqa: F403, F405
"""Values of the wrong type or size in publish()."""

import rospy
from geometry_msgs.msg import *
from sensor_msgs.msg import *
from std_msgs.msg import *

rospy.init_node("w")
cases = [
    (Int8, [200, "x", 1.0, None, True, -129]),
    (UInt8, [-1, 256, "a"]),
    (Int32, [2**31, 1.5, "5", [1]]),
    (UInt64, [-1, 2**64]),
    (Float32, ["x", None, True, [1]]),
    (Float64, ["1.0", 1]),
    (Bool, [2, "x", None, 0]),
    (String, [5, None, "\u00e9", "x" * 3, ["a"]]),
    (Time, [5, rospy.Duration(1), 1.5]),
    (Duration, [rospy.Time(1), 2]),
    (Header, [1, (1,)]),
    (Vector3, [(1, 2, 3), 1, "a"]),
    (Point, [Vector3(1, 2, 3)]),
    (Twist, [Vector3(), 5, None, Pose()]),
    (LaserScan, [[1.0]]),
    (UInt8MultiArray, [b"abc", [1, 2]]),
    (Empty, [1, None, Empty()]),
]
for cls, values in cases:
    for number, v in enumerate(values):
        # A topic for each: what a failed publish() leaves in rospy's buffer goes out with the next message, and may
        # close the connection.
        name = "t_%s_%d" % (cls.__name__.lower(), number)
        sub = rospy.Subscriber(name, cls, lambda m: None)
        pub = rospy.Publisher(name, cls, queue_size=1)
        while not pub.get_num_connections():
            rospy.sleep(0.02)
        try:
            pub.publish(v)
            print(cls.__name__, repr(v)[:30].replace("\n", " "), "ok")
        except Exception as e:
            print(cls.__name__, repr(v)[:30].replace("\n", " "), type(e).__module__, type(e).__name__, e)
