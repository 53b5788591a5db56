#!/usr/bin/env python
# ruff: noqa: B023
"""A day of a chassis: a task, navigation, steps, driving, readings. What the chassis receives is compared."""

import argparse
import math
import sys
import threading

import actionlib
import rospy
import tf
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Pose, Pose2D, PoseStamped, PoseWithCovarianceStamped, Quaternion, Twist
from nav_msgs.msg import OccupancyGrid, Odometry
from sensor_msgs.msg import LaserScan
from woosh_msgs.msg import (
    Battery,
    MoveBaseAction,
    MoveBaseGoal,
    RobotStatus,
    StepControl,
    StepControlAction,
    StepControlGoal,
)
from woosh_msgs.srv import ExecTask, ExecTaskRequest


class Tour(object):
    def __init__(self, mark):
        self.mark = mark
        self.state = None
        self.states = []
        self.last = {}
        self.lock = threading.Lock()
        self.sent = 0
        self.drive = rospy.Publisher("/smooth_cmd_vel", Twist, queue_size=10)
        self.simple = rospy.Publisher("/move_base_simple/goal", PoseStamped, queue_size=10)
        rospy.Subscriber("/robot_status", RobotStatus, self.on_status, queue_size=10)
        rospy.Subscriber("/battery", Battery, self.keep, callback_args="battery")
        rospy.Subscriber("/movebase_pose2d", Pose2D, self.keep, "pose")
        rospy.Subscriber("/odom", Odometry, self.keep, callback_args="odom", queue_size=1)
        rospy.Subscriber("/scan", LaserScan, self.keep, "scan", tcp_nodelay=True)
        rospy.on_shutdown(self.stop)

    def on_status(self, msg):
        if self.state != msg.task_state:
            self.states.append((msg.task_id, self.state, msg.task_state))
        self.state = msg.task_state

    def keep(self, msg, name):
        with self.lock:
            self.last[name] = msg

    def stop(self):
        rospy.loginfo("stopping")
        self.drive.publish(Twist())
        while rospy.get_param("/noted/velocity", 0) < 3:
            rospy.sleep(0.02)

    def send(self, client, goal, **callbacks):
        """The chassis begins when the client knows the handle: rospy loses what comes earlier."""
        client.send_goal(goal, **callbacks)
        self.sent += 1
        rospy.set_param("/sent", self.sent)

    def wait_until(self, condition, seconds=20):
        end = rospy.Time.now() + rospy.Duration(seconds)
        rate = rospy.Rate(20)
        while not rospy.is_shutdown() and rospy.Time.now() < end:
            if condition():
                return True
            rate.sleep()
        return False

    def task(self):
        rospy.wait_for_service("/exec_task", timeout=20)
        call = rospy.ServiceProxy("/exec_task", ExecTask)
        print(self.wait_until(lambda: self.state == 7))
        request = ExecTaskRequest()
        request.task_id, request.mark_no, request.task_type = 42, self.mark, 1
        print(call(request))
        print(self.wait_until(lambda: (42, 3, 7) in self.states))
        print(self.states)
        print(call(mark_no="refused", task_id=3).message)
        try:
            call(task_id="forty")
        except Exception as e:
            print(type(e).__name__, e)

    def navigate(self):
        client = actionlib.SimpleActionClient("move_base", MoveBaseAction)
        client.wait_for_server(rospy.Duration(20))
        turned = tf.transformations.quaternion_from_euler(0, 0, math.radians(90))
        goal = MoveBaseGoal()
        goal.target_pose.header.frame_id = "map"
        for x in (1.5, 9):
            goal.target_pose.header.stamp = rospy.Time.now()
            goal.target_pose.pose = Pose(Point(x, 2, 0), Quaternion(*turned))
            self.send(client, goal, done_cb=lambda s, r: rospy.loginfo("done %d %s", s, type(r).__name__))
            client.wait_for_result(rospy.Duration(20))
            print(client.get_state() == GoalStatus.SUCCEEDED, client.get_goal_status_text())
        goal.target_pose.pose.position.x = 20
        self.send(client, goal)
        self.wait_until(lambda: client.get_state() == GoalStatus.ACTIVE)
        client.cancel_all_goals()
        print(client.wait_for_result(rospy.Duration(20)), client.get_state())

    def on_percent(self, feedback):
        rospy.loginfo("%.0f%%" % feedback.percent)
        rospy.set_param("/percent", feedback.percent)

    def step(self):
        client = actionlib.SimpleActionClient("/cmd_vel_control", StepControlAction)
        client.wait_for_server()
        goal = StepControlGoal(mode=StepControlGoal.EXCUTE)
        goal.stepControl.append(StepControl(data=0.5))
        self.send(client, goal, feedback_cb=self.on_percent)
        print(client.wait_for_result(rospy.Duration(20)), client.get_result())
        rospy.set_param("/percent", 0)
        self.send(client, goal)
        self.wait_until(lambda: client.get_state() == GoalStatus.ACTIVE)
        client.cancel_goal()
        print(client.wait_for_result(), client.get_state(), client.get_result().result)

    def read(self):
        self.wait_until(lambda: len(self.last) == 4)
        with self.lock:
            battery, pose, odom, scan = (self.last[n] for n in ("battery", "pose", "odom", "scan"))
        q = odom.pose.pose.orientation
        print(battery.batteryPercentage, "%.1f" % battery.batteryVoltage, pose)
        print(tf.transformations.euler_from_quaternion([q.x, q.y, q.z, q.w]), odom.twist.twist.linear.x)
        print(
            min(r for r in scan.ranges if not math.isinf(r)), scan.ranges.index(min(scan.ranges)), scan.ranges
        )
        grid = rospy.wait_for_message("/map", OccupancyGrid, timeout=20)
        print(grid.info.width, grid.info.resolution, [grid.data[i * 4 : (i + 1) * 4] for i in range(3)])

    def place(self):
        where = PoseWithCovarianceStamped()
        where.header.frame_id = "map"
        where.pose.pose.position.x = 1.5
        where.pose.covariance = list(where.pose.covariance)
        where.pose.covariance[0] = 0.25
        rospy.Publisher("/initialpose", PoseWithCovarianceStamped, queue_size=1, latch=True).publish(where)
        self.wait_until(lambda: self.simple.get_num_connections())
        goal = PoseStamped()
        goal.header.frame_id = "map"
        for goal.pose.position.x in (3, 4):
            self.simple.publish(goal)
        print(goal.header.seq)
        for kind, count in (("initial_pose", 1), ("goal", 2)):
            print(self.wait_until(lambda: rospy.get_param("/noted/" + kind, 0) >= count))

    def go(self):
        self.wait_until(lambda: self.drive.get_num_connections())
        twist = Twist()
        twist.linear.x = 0.2
        rate = rospy.Rate(20)
        for i in range(6):
            twist.angular.z = 0.5 * (i // 3)
            self.drive.publish(twist)
            rate.sleep()


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("mark")
    parser.add_argument("--parts", nargs="*", default=["task", "read", "navigate", "step", "place", "go"])
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("tour")
    print(rospy.get_name(), rospy.get_param("~speed"))
    tour = Tour(arguments.mark)
    for part in arguments.parts:
        print("--", part)
        getattr(tour, part)()
    sys.exit(4)
