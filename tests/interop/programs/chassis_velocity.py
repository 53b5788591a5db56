"""Velocity by a loop, position from odometry, stop at shutdown."""

import rospy
from geometry_msgs.msg import Pose2D, Twist, Vector3

rospy.init_node("driver")
poses = []
rospy.Subscriber("/movebase_pose2d", Pose2D, poses.append)
pub = rospy.Publisher("/smooth_cmd_vel", Twist, queue_size=1)
rospy.on_shutdown(lambda: pub.publish(Twist()))
while not pub.get_num_connections() or not poses:
    rospy.sleep(0.05)
begin = poses[-1]
rate = rospy.Rate(20)
for _ in range(30):
    pub.publish(Twist(linear=Vector3(0.2, 0, 0)))
    rate.sleep()
pub.publish(Twist())
rospy.sleep(0.5)
moved = ((poses[-1].x - begin.x) ** 2 + (poses[-1].y - begin.y) ** 2) ** 0.5
print(moved > 0.02)
