"""Obstacle avoidance: a scan's sectors, inf and nan, a decision, hysteresis by time."""

import math

import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import LaserScan

state = {"front": 10.0, "left": 10.0, "right": 10.0, "count": 0}


def scan_callback(msg):
    ranges = [r if not (math.isinf(r) or math.isnan(r)) else msg.range_max for r in msg.ranges]
    n = len(ranges)
    state["right"] = min(min(ranges[0 : n // 3]), 10)
    state["front"] = min(ranges[n // 3 : 2 * n // 3])
    state["left"] = min(ranges[2 * n // 3 :])
    state["count"] += 1
    state["closest"] = msg.angle_min + ranges.index(min(ranges)) * msg.angle_increment
    if msg.intensities:
        state["bright"] = max(msg.intensities)


def decide():
    t = Twist()
    if state["front"] > 0.8:
        t.linear.x = min(0.3, state["front"] / 10.0)
    else:
        t.angular.z = 0.5 if state["left"] > state["right"] else -0.5
    return t


rospy.init_node("wander", anonymous=False)
rospy.Subscriber("/wander_scan", LaserScan, scan_callback)
scans = rospy.Publisher("/wander_scan", LaserScan, queue_size=10)
while scans.get_num_connections() < 1:
    rospy.sleep(0.02)
rate = rospy.Rate(50)
inf, nan = float("inf"), float("nan")
for i, ranges in enumerate(
    ([1.0] * 9, [inf] * 9, [nan, 2.0, 3.0, 0.5, 0.4, nan, 5, 6, 7], (2, 2, 2, 0.1, 1, 1, 0.2, 1, 1))
):
    scan = LaserScan(angle_min=-math.pi / 2, angle_increment=math.pi / 8, range_min=0.1, range_max=12.0)
    scan.header.stamp = rospy.Time.now()
    scan.ranges = ranges
    scan.intensities = [float(j * i) for j in range(9)]
    scans.publish(scan)
    while state["count"] <= i:
        rate.sleep()
    cmd = decide()
    print({k: round(v, 3) for k, v in sorted(state.items())}, round(cmd.linear.x, 3), cmd.angular.z)
