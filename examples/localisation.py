"""After power-up: tell the robot where it stands, then wait until it knows."""

from _robot import robot

from woosh_pure import Pose2D

with robot() as chassis:
    chassis.set_pose(Pose2D(0.0, 0.0, 0.0), position_deviation=0.3)
    estimate = chassis.localization.wait(timeout=5)
    print("localised at", estimate.pose, "± %.2f m" % estimate.covariance[0, 0] ** 0.5)
