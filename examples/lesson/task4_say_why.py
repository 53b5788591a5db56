"""Task 4: say why the robot does not drive, wait until the cause is gone, and try again."""

from woosh_pure import Chassis, GoalFailed, MotionRefused


def visit(chassis: Chassis, mark: str) -> bool:
    """Drive to a mark, in at most three attempts; True when the robot has arrived."""
    for attempt in (1, 2, 3):
        try:
            chassis.go_to_mark(mark).wait()
            print(f"{mark}: arrived at attempt {attempt}")
            return True
        except MotionRefused as refused:  # it has not moved
            print(f"{mark}: it did not start: {refused}")
        except GoalFailed as failed:  # it has moved, and did not arrive
            print(f"{mark}: it did not arrive: {failed}")
        chassis.wait_until_ready(timeout=60)  # a person turns the red button to release it
    return False


with Chassis() as chassis:
    for mark in ("B1", "kitchen"):
        if not visit(chassis, mark):
            print(f"{mark}: given up")
