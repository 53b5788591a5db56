"""Task 3: visit every mark, always the nearest of the remaining ones next."""

import math

from woosh_pure import Chassis

MARKS = {"A1": (3.0, 1.0), "A2": (5.5, 2.5), "B1": (8.5, -2.0), "P1": (-0.5, 2.5)}  # metres, from the map

with Chassis() as chassis:
    remaining = dict(MARKS)
    while remaining:
        pose = chassis.pose.wait(timeout=5)
        distances = {mark: math.hypot(x - pose.x, y - pose.y) for mark, (x, y) in remaining.items()}
        nearest = min(distances, key=lambda mark: distances[mark])
        print(f"{nearest} is nearest: {distances[nearest]:.1f} m")
        chassis.go_to_mark(nearest).wait()
        del remaining[nearest]
    print("all visited")
