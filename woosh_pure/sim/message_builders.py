"""Fill messages from the world: one function for each published topic. Called with the world's lock held."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rosproto.codec import DynamicMessage
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.served_graph.stamped import stamp
from woosh_pure.sim.sensors import camera_depth, camera_picture, camera_points, cast
from woosh_pure.sim.world import World
from woosh_pure.values.messages import message_type, set_pose, set_yaw

BEAMS = 360
RANGE_MIN, RANGE_MAX = 0.05, 30.0
_ANGLES = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)


def _set_twist(target: DynamicMessage, velocity: Velocity) -> None:
    target.linear.x, target.linear.y, target.angular.z = velocity.vx, velocity.vy, velocity.wz


def fill_status(world: World, m: DynamicMessage, now: float) -> None:
    """woosh_msgs/RobotStatus."""
    record = world.status()
    m.task_id, m.task_type, m.task_state = record.task_id, int(record.task_type), int(record.task_state)
    m.action_type, m.action_state = int(record.action_type), int(record.action_state)
    m.robot_state, m.robot_mode = int(record.robot_state), int(record.robot_mode)
    m.work_mode, m.wait_id = int(record.work_mode), record.wait_id
    m.dest, m.msg, m.time = record.destination, record.message, int(now)


def _pose2d(world: World, m: DynamicMessage, now: float) -> None:
    pose = world.believed_pose
    m.x, m.y, m.theta = pose.x, pose.y, pose.yaw


def _amcl(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "map", now)
    set_pose(m.pose.pose, world.believed_pose)
    spread = 0.0025 if world.located else 1.0
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = covariance[35] = spread
    m.pose.covariance = covariance


def _odometer(world: World, m: DynamicMessage, now: float) -> None:
    m.data = world.body.distance


def _battery(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "", now)
    b = world.battery
    m.batteryPercentage = round(b.percent)
    m.chargeMode, m.chargeStatus = int(b.automatic), int(b.charging)
    m.batteryVoltage, m.batteryCurrent = b.voltage, b.current
    m.timeRemain = 0.0 if b.charging else b.capacity / max(-b.current, 0.1) * 60.0
    m.tempMax, m.tempMin = 27, 25
    m.capacityRemain, m.capacityFull, m.capacityDesign = b.capacity, b.FULL_AH, b.FULL_AH
    m.chargeCycle, m.batteryCycle = 12, 1000
    m.cellVoltageMax, m.cellVoltageMin = b.voltage / 8 + 0.01, b.voltage / 8 - 0.01


def _bms(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "", now)
    b = world.battery
    m.current, m.voltageTotal = b.current, b.voltage
    m.voltageMax, m.voltageMin = b.voltage / 8 + 0.01, b.voltage / 8 - 0.01
    m.temperatureMax, m.temperatureMin = 27.0, 25.0
    m.chargeCycle, m.capacityResidue, m.capacityTotal, m.switchStatus = 12, b.capacity, b.FULL_AH, 3


def _parameter(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "", now)
    m.wheelPerimeter, m.wheelDistant = 0.534, 0.42
    m.ratioLeft = m.ratioRight = 25.0
    m.pulsePerCircle, m.maxRPM = 10000, 3000.0
    m.minSpeed, m.maxSpeed = 0.01, world.body.limits.linear
    m.maxLinear, m.maxAngular = 1.0, 1.0
    m.joystickMaxLinear, m.joystickMaxAngular = 0.5, 0.8


def _information(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "", now)
    m.hardwareVersion, m.softwareVersion, m.IAPSoftwareVersion = "sim-1", "woosh_pure simulation", "sim-iap"
    m.movebaseType = "omnidirectional" if world.body.limits.omnidirectional else "differential"
    _parameter(world, m.parameter, now)


def _twist(world: World, m: DynamicMessage, now: float) -> None:
    _set_twist(m, world.body.velocity)


def _odometry(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "odom", now)
    m.child_frame_id = "base_link"
    set_pose(m.pose.pose, world.body.odometry)
    _set_twist(m.twist.twist, world.body.velocity)


def _odometry_raw(world: World, m: DynamicMessage, now: float) -> None:
    _odometry(world, m, now)
    set_pose(m.pose.pose, world.body.wheel_odometry)


def _scan(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "laser", now)
    m.angle_min, m.angle_increment = -math.pi, 2.0 * math.pi / BEAMS
    m.angle_max = m.angle_min + m.angle_increment * (BEAMS - 1)
    m.scan_time, m.time_increment = 0.1, 0.0
    m.range_min, m.range_max = RANGE_MIN, RANGE_MAX
    m.ranges = cast(world.site.grid, world.body.pose, _ANGLES, RANGE_MAX, world.obstacles)


def _imu(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "imu", now)
    set_yaw(m.orientation, world.body.odometry.yaw)
    m.angular_velocity.z = world.body.velocity.wz + world.random.gauss(0.0, 0.002)
    m.linear_acceleration.x = world.random.gauss(0.0, 0.02)
    m.linear_acceleration.y = world.body.velocity.vx * world.body.velocity.wz
    m.linear_acceleration.z = 9.81


def _color(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "camera_1_color", now)
    _set_image(m, "rgb8", camera_picture(world.site.grid, world.body.pose, world.obstacles))


def _depth(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "camera_1_depth", now)
    _set_image(m, "16UC1", camera_depth(world.site.grid, world.body.pose, world.obstacles))


def _set_image(m: DynamicMessage, encoding: str, pixels: NDArray[np.uint8] | NDArray[np.uint16]) -> None:
    m.height, m.width, m.encoding = pixels.shape[0], pixels.shape[1], encoding
    m.step = pixels.strides[0]
    m.data = np.ascontiguousarray(pixels).reshape(-1).view(np.uint8)


def _points(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "camera_1_depth", now)
    _set_cloud(m, camera_points(world.site.grid, world.body.pose, world.obstacles))


def _obstacle_points(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "camera_1_depth", now)
    _set_cloud(m, camera_points(world.site.grid, world.body.pose, world.obstacles, floor=False))


def _set_cloud(m: DynamicMessage, points: NDArray[np.float32]) -> None:
    field = message_type("sensor_msgs/PointField")
    m.height, m.width, m.is_dense = 1, points.shape[0], True
    m.fields = [field(name=n, offset=4 * i, datatype=7, count=1) for i, n in enumerate("xyz")]
    m.point_step, m.row_step = 12, 12 * points.shape[0]
    m.data = np.ascontiguousarray(points, np.float32).reshape(-1).view(np.uint8)


def _localization_state(world: World, m: DynamicMessage, now: float) -> None:
    m.data = 1 if world.located else 0


def _inputs(world: World, m: DynamicMessage, now: float) -> None:
    stamp(m, "", now)
    # Module 1: keys of the chassis (woosh_msgs/IO). Which line is which is assumed.
    line = message_type("woosh_msgs/IO")
    m.IOs = [
        line(module=1, submodule=1, id=number, status=int(pressed))
        for number, pressed in enumerate((world.emergency_stop, world.bumper))
    ]


def fill_plan(path: list[Pose2D], m: DynamicMessage, now: float) -> None:
    """nav_msgs/Path."""
    stamp(m, "map", now)
    stamped = message_type("geometry_msgs/PoseStamped")
    m.poses = []
    for pose in path:
        one = stamped()
        stamp(one, "map", now)
        set_pose(one.pose, pose)
        m.poses.append(one)


PERIODIC: dict[str, tuple[Callable[[World, DynamicMessage, float], None], float]] = {
    "/movebase_pose2d": (_pose2d, 10.0),
    "/odometer": (_odometer, 2.0),
    "/battery": (_battery, 2.0),
    "/amcl_pose": (_amcl, 5.0),
    "/information": (_information, 2.0),
    "/driver_base/bms": (_bms, 2.0),
    "/driver_base/parameter": (_parameter, 4.0),
    "/odom_twist": (_twist, 25.0),
    "/scan": (_scan, 10.0),
    "/imu/data_raw": (_imu, 25.0),
    "/odom_raw": (_odometry_raw, 25.0),
    "/odom": (_odometry, 25.0),
    "/camera_1/color/image_raw": (_color, 5.0),
    "/camera_1/depth/image_raw": (_depth, 5.0),
    "/camera_1/depth/points": (_points, 5.0),
    "/camera_1/depth/cloud_without_planes": (_obstacle_points, 5.0),
    "/localization_state": (_localization_state, 1.0),
    "/IO_input": (_inputs, 5.0),
}
"""By topic: the function that fills a message, and the messages per second of wall time.

The first provider in the table publishes them. (The rates are assumed: none of a real chassis are known.)
"""
