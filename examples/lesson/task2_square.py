"""Task 2: a square of one metre, and a triangle, by one function."""

from woosh_pure import Chassis


def polygon(chassis: Chassis, corners: int, side: float) -> None:
    """Drive along a polygon; at the end the robot stands as it did in the beginning."""
    for _ in range(corners):
        chassis.forward(side).wait()
        chassis.left(360 / corners, speed=0.5).wait()  # the outer angle: 90 degrees for a square


with Chassis() as chassis:
    polygon(chassis, 4, 1.0)
    print("a square; it stands at", chassis.pose.wait(timeout=5))
    polygon(chassis, 3, 1.0)
    print("a triangle; it stands at", chassis.pose.wait(timeout=5))
