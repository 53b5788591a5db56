"""Odometry and frames: a broadcaster, a static frame, a buffer; lookups, time-outs, extrapolation, messages."""

import math

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry

rospy.init_node("odometry_tf")
buffer = tf2_ros.Buffer(rospy.Duration(30))
listener = tf2_ros.TransformListener(buffer)
static = tf2_ros.StaticTransformBroadcaster()
broadcaster = tf2_ros.TransformBroadcaster()


def transform(parent, child, x, y, yaw, stamp):
    t = TransformStamped()
    t.header.stamp, t.header.frame_id, t.child_frame_id = stamp, parent, child
    t.transform.translation.x, t.transform.translation.y = x, y
    t.transform.rotation.z, t.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return t


while not broadcaster.pub_tf.get_num_connections():
    rospy.sleep(0.02)
began = rospy.Time.now()
static.sendTransform(
    [transform("t_base", "t_laser", 0.3, 0, math.pi, began), transform("t_map", "t_odom", 1, 0, 0, began)]
)
x = y = yaw = 0.0
odoms = rospy.Publisher("odom", Odometry, queue_size=10)
for i in range(10):
    v, w = 0.5, 0.2
    x += v * math.cos(yaw) * 0.1
    y += v * math.sin(yaw) * 0.1
    yaw += w * 0.1
    stamp = began + rospy.Duration(0.1 * i)
    odom = Odometry(child_frame_id="t_base")
    odom.header.frame_id, odom.header.stamp = "t_odom", stamp
    odom.twist.twist = Twist()
    odoms.publish(odom)
    broadcaster.sendTransform(transform("t_odom", "t_base", x, y, yaw, stamp))
    rospy.sleep(0.02)


def show(t):
    q = t.transform.rotation
    print(
        t.header.frame_id,
        t.child_frame_id,
        *["%.5f" % (v + 0.0) for v in (t.transform.translation.x, t.transform.translation.y, q.z, q.w)],
    )


print(buffer.can_transform("t_map", "t_laser", rospy.Time(0), rospy.Duration(5)))
end = began + rospy.Duration(0.9)
while not buffer.can_transform("t_odom", "t_base", end):
    rospy.sleep(0.02)
show(buffer.lookup_transform("t_map", "t_laser", rospy.Time(0)))
show(buffer.lookup_transform("t_map", "t_base", began + rospy.Duration(0.45), rospy.Duration(1)))
show(buffer.lookup_transform("t_laser", "t_map", rospy.Time()))
show(buffer.lookup_transform_full("t_base", end, "t_base", began, "t_map"))
for arguments in (("t_map", "nowhere", rospy.Time(0)), ("t_map", "t_base", began + rospy.Duration(50)), ("t_map", "t_base", began - rospy.Duration(5)),
                  ("", "t_base", rospy.Time(0)), ("/t_map", "t_base", rospy.Time(0)), ("t_map", "t_base", rospy.Time(0), 5)):  # fmt: skip
    try:
        show(buffer.lookup_transform(*arguments))
    except (tf2_ros.LookupException, tf2_ros.ConnectivityException, tf2_ros.ExtrapolationException) as e:
        print(type(e).__name__, "".join(c for c in str(e)[:60] if not c.isdigit()))
    except Exception as e:
        print("other", type(e).__name__, str(e)[:60])
print(
    buffer.can_transform("t_map", "nowhere", rospy.Time(0), rospy.Duration(0.1)),
    issubclass(tf2_ros.LookupException, tf2_ros.TransformException),
)
