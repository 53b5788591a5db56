"""Task 5: look ahead with the laser scanner; drive where it is free, and turn away from walls."""

import math

from woosh_pure import Chassis

STEP, KEEP = 0.5, 0.6  # metres: how far it drives at once, and the distance that it keeps


def free_ahead(chassis: Chassis) -> float:
    """Metres to the nearest thing in a sector of 60 degrees in front of the robot."""
    scan = chassis.scan.wait(timeout=5)
    ahead = abs(scan.angles()) < math.radians(30)
    return float(scan.ranges[ahead].min())


with Chassis() as chassis:
    for _ in range(12):
        free = free_ahead(chassis)
        if free > STEP + KEEP:
            print(f"{free:.1f} m are free: forward")
            chassis.forward(STEP).wait()
        else:
            print(f"only {free:.1f} m are free: left")
            chassis.left(60, speed=0.5).wait()
