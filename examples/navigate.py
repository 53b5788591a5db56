"""Plan a path, drive it, and follow way points."""

import math

from _robot import robot

from woosh_pure import Pose2D

with robot() as chassis:
    path = chassis.plan(Pose2D(6.0, 0.0))
    print(f"a way of {len(path)} points:", *(f"({p.x:.1f}, {p.y:.1f})" for p in path))
    print(chassis.go_to(6.0, 0.0, math.pi).wait(timeout=60).sentence())
    corners = [Pose2D(6.0, 1.0), Pose2D(5.0, 1.0, math.pi)]
    print(chassis.follow(corners, point_by_point=True).wait(timeout=60).sentence())
