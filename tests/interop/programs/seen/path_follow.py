"""Following a path: Path and Odometry messages, yaw by hand, nearest point, pure pursuit, arrays of poses."""

import math

import rospy
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped, PoseWithCovarianceStamped, Quaternion
from nav_msgs.msg import Odometry, Path

rospy.init_node("path_follow")


def yaw_of(q):
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def quaternion(yaw):
    return Quaternion(x=0, y=0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))


path = Path()
path.header.frame_id = "map"
for i in range(20):
    p = PoseStamped()
    p.pose.position = Point(i * 0.5, math.sin(i * 0.25), 0)
    p.pose.orientation = quaternion(math.atan(0.5 * math.cos(i * 0.25)))
    path.poses.append(p)
pub = rospy.Publisher("plan", Path, queue_size=1, latch=True)
pub.publish(path)
plan = rospy.wait_for_message("plan", Path, timeout=20)
print(
    len(plan.poses),
    plan.poses[3].pose.position.x,
    round(yaw_of(plan.poses[3].pose.orientation), 6),
    type(plan.poses).__name__,
)
print(
    plan.header.frame_id,
    plan.poses == path.poses,
    plan.poses[5].pose == path.poses[5].pose,
    plan.poses[:2] == path.poses[:2],
)
odom_pub = rospy.Publisher("odom", Odometry, queue_size=10)
done = []


def on_odom(msg):
    x, y = msg.pose.pose.position.x, msg.pose.pose.position.y
    yaw = yaw_of(msg.pose.pose.orientation)
    i = min(
        range(len(plan.poses)),
        key=lambda k: math.hypot(plan.poses[k].pose.position.x - x, plan.poses[k].pose.position.y - y),
    )
    target = plan.poses[min(i + 2, len(plan.poses) - 1)].pose.position
    alpha = math.atan2(target.y - y, target.x - x) - yaw
    done.append((i, round(2 * math.sin(alpha), 5), round(msg.pose.covariance[7], 3), msg.child_frame_id))


rospy.Subscriber("odom", Odometry, on_odom, queue_size=10)
while not odom_pub.get_num_connections():
    rospy.sleep(0.02)
odom = Odometry(child_frame_id="base_link")
odom.pose.covariance = [0.1 * i for i in range(36)]
for i in range(4):
    odom.pose.pose = Pose(Point(i * 2.0, 0.3, 0), quaternion(0.1 * i))
    odom.twist.twist.linear.x = 0.5
    odom_pub.publish(odom)
    while len(done) <= i:
        rospy.sleep(0.01)
print(done)
cloud = PoseArray(poses=[p.pose for p in plan.poses[:3]])
print(sum(p.position.x for p in cloud.poses) / len(cloud.poses), len(str(cloud)))
initial = PoseWithCovarianceStamped()
initial.pose.covariance[0] = 0.25
initial.pose.covariance[35] = 0.0685
print(type(initial.pose.covariance).__name__, sum(initial.pose.covariance), len(initial.pose.covariance))
