"""A chassis made of rospy nodes that prints what it receives; runs where Debian's rospy is."""

import sys
import threading

import actionlib
import rospy
from geometry_msgs.msg import Pose2D, PoseStamped, PoseWithCovarianceStamped, Twist
from nav_msgs.msg import OccupancyGrid, Odometry
from sensor_msgs.msg import LaserScan
from woosh_msgs.msg import (
    Battery,
    MoveBaseAction,
    MoveBaseResult,
    RobotStatus,
    StepControlAction,
    StepControlFeedback,
    StepControlResult,
)
from woosh_msgs.srv import ExecTask, ExecTaskResponse

rospy.init_node("ros_interface", disable_signals=True)
lock = threading.Lock()


noted = {}


def note(kind, *words):
    """Print it, and tell by a parameter how many of this kind there are: so the program can wait for its arrival."""
    with lock:
        sys.stdout.write("> " + " ".join([kind, *(str(word).replace("\n", " ") for word in words)]) + "\n")
        sys.stdout.flush()
        noted[kind] = noted.get(kind, 0) + 1
        rospy.set_param("/noted/" + kind, noted[kind])


goals = []


def begin(goal, server):
    """Wait until the client knows the handle of this goal, and the server its client: rospy loses what comes earlier."""
    publishers = server.action_server.result_pub, server.action_server.feedback_pub
    goals.append(goal)
    while rospy.get_param("/sent", 0) < len(goals) or not all(p.get_num_connections() for p in publishers):
        rospy.sleep(0.01)


def velocities(topic):
    seen = []

    def callback(m):  # how often a velocity comes is a matter of time; which ones come is not
        velocity = (m.linear.x, m.linear.y, m.angular.z)
        if not seen or seen[-1] != velocity:
            seen.append(velocity)
            note("velocity", topic, velocity, m._connection_header["callerid"])

    return callback


for topic in ("/smooth_cmd_vel", "/base_cmd_vel"):
    rospy.Subscriber(topic, Twist, velocities(topic))


def initial(m):
    note("initial_pose", m.header.frame_id, m.pose.pose.position.x, m.pose.covariance[0])


rospy.Subscriber("/initialpose", PoseWithCovarianceStamped, initial)
rospy.Subscriber(
    "/move_base_simple/goal",
    PoseStamped,
    lambda m: note("goal", m.header.seq, m.header.frame_id, m.pose.position.x),
)
status = rospy.Publisher("/robot_status", RobotStatus, queue_size=10, latch=True)
battery = rospy.Publisher("/battery", Battery, queue_size=10)
pose = rospy.Publisher("/movebase_pose2d", Pose2D, queue_size=10)
odom = rospy.Publisher("/odom", Odometry, queue_size=10)
scan = rospy.Publisher("/scan", LaserScan, queue_size=2)
map_ = rospy.Publisher("/map", OccupancyGrid, queue_size=1, latch=True)


def say(task_id, state):
    status.publish(RobotStatus(task_id=task_id, task_state=state, robot_state=4, robot_mode=1, work_mode=2))


def exec_task(request):
    note("task", request)
    if request.mark_no == "refused":
        return ExecTaskResponse(False, "other task running", 4)
    say(request.task_id, 3)
    threading.Timer(0.5, say, (request.task_id, 7)).start()
    return ExecTaskResponse(True, "", 4)


rospy.Service("/exec_task", ExecTask, exec_task)


def step(goal):
    note("step", goal)
    begin(goal, steps)
    for percent in (30.0, 60.0, 100.0):
        steps.publish_feedback(StepControlFeedback(executeMode=1, percent=percent))
        while rospy.get_param("/percent", 0) < percent:  # the result is another topic, and may overtake
            rospy.sleep(0.01)
            if steps.is_preempt_requested():
                note("step_preempted")
                steps.set_preempted(StepControlResult(result=-1))
                return
    steps.set_succeeded(StepControlResult(result=1, executeMode=1, percent=100.0), "done")


steps = actionlib.SimpleActionServer("/cmd_vel_control", StepControlAction, step, auto_start=False)
steps.start()


def go(goal):
    x = goal.target_pose.pose.position.x
    note("navigation", goal.target_pose.header.frame_id, goal.target_pose.pose)
    begin(goal, base)
    if x < 5:
        base.set_succeeded(MoveBaseResult(), "reached")
        return
    while x > 10:
        rospy.sleep(0.01)
        if base.is_preempt_requested():
            note("navigation_preempted")
            base.set_preempted(MoveBaseResult())
            return
    base.set_aborted(MoveBaseResult(), "unreachable")


base = actionlib.SimpleActionServer("/move_base", MoveBaseAction, go, auto_start=False)
base.start()
say(1, 7)
grid = OccupancyGrid(data=[0, 100, -1, 0] * 3)
grid.header.frame_id = "map"
grid.info.width, grid.info.height, grid.info.resolution = 4, 3, 0.05
map_.publish(grid)
sys.stdout.write("up\n")
sys.stdout.flush()
try:
    while not rospy.is_shutdown():
        battery.publish(Battery(batteryPercentage=55, batteryVoltage=25.5))
        pose.publish(Pose2D(1.0, 2.0, 0.5))
        moved = Odometry()
        moved.pose.pose.orientation.z, moved.pose.pose.orientation.w = 0.2, 0.98
        moved.twist.twist.linear.x = 0.1
        odom.publish(moved)
        scan.publish(LaserScan(ranges=[1.0, 0.4, 2.5, float("inf")], range_max=10, angle_increment=0.1))
        rospy.sleep(0.05)
finally:
    rospy.signal_shutdown("interrupted")  # which the threads of the actions wait for
