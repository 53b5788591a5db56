"""Drive by velocity. It bypasses the chassis's own protection: clear the area and watch the robot."""

from _robot import robot

with robot(speed=1.0) as chassis:  # a velocity lasts as long by your clock
    start = chassis.odometry.wait(timeout=5).pose
    with chassis.velocity(bypasses_protection=True, max_linear=0.3) as drive:
        drive.hold(0.2, seconds=1.0)  # forward, m/s
        drive.hold(0.1, 0.3, seconds=1.0)  # an arc: m/s and rad/s
        try:
            drive.set(2.0)
        except ValueError as refused:
            print("refused:", refused)
    # Leaving the block sent zero, whatever happened inside.
    chassis.measured_velocity.wait_for(lambda v: v.is_standing(), timeout=5)
    print(f"moved {start.distance_to(chassis.odometry.wait().pose):.2f} m and stopped")
