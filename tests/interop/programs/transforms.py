"""tf.transformations has no real counterpart here; tf2_ros has: buffer, listener, broadcasters."""

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped

rospy.init_node("transforms")


def stamped(parent, child, x, stamp):
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, stamp
    message.transform.translation.x = x
    message.transform.rotation.z = message.transform.rotation.w = 0.5**0.5
    return message


buffer = tf2_ros.Buffer(rospy.Duration(20))
listener = tf2_ros.TransformListener(buffer)
fixed = tf2_ros.StaticTransformBroadcaster()
moving = tf2_ros.TransformBroadcaster()
now = rospy.Time.now()
fixed.sendTransform(stamped("base", "laser", 0.5, now))
i = 0
while not buffer.can_transform("map", "laser", rospy.Time(0)) or i < 2:
    moving.sendTransform(stamped("map", "base", 1.0, now + rospy.Duration(0.1 * i)))
    i += 1
    rospy.sleep(0.1)
moving.sendTransform(
    [stamped("map", "base", 3.0, now + rospy.Duration(60)), stamped("island", "tree", 1.0, now)]
)
found = buffer.lookup_transform("map", "laser", now + rospy.Duration(60), rospy.Duration(20))
print(
    found.header.frame_id,
    found.child_frame_id,
    round(found.transform.translation.x, 6),
    round(found.transform.translation.y, 6),
)
print(round(found.transform.rotation.z, 6), type(found).__name__)
for target, source, when in (
    ("map", "nowhere", rospy.Time(0)),
    ("nowhere", "map", rospy.Time(0)),
    ("map", "tree", rospy.Time(0)),
    ("map", "base", now + rospy.Duration(1000)),
    ("map", "base", rospy.Time(1)),
):
    try:
        buffer.lookup_transform(target, source, when)
    except tf2_ros.TransformException as e:
        text = str(e)
        print(type(e).__name__, text.split(" extrapolation ")[0][:90])
print(
    buffer.can_transform("map", "base", rospy.Time(0)),
    buffer.can_transform("map", "zzz", rospy.Time(0), rospy.Duration(0.2)),
)
