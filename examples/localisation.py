"""After power-up: tell the robot where it stands, then wait until it knows."""

from _robot import robot

from woosh_pure import ChassisError, Pose2D

with robot() as chassis:
    chassis.set_pose(Pose2D(0.0, 0.0, 0.0), position_deviation=0.3)
    estimate = chassis.localization.wait(timeout=5)
    print("localised at", estimate.pose, "± %.2f m" % estimate.covariance[0, 0] ** 0.5)

    # Some chassis have services for it, which answer; they are found by their types.
    try:
        chassis.initialise()
        chassis.set_pose(Pose2D(0.0, 0.0, 0.0), via="service")
        print("the chassis has taken its position")
    except ChassisError as refused:
        print(refused)
