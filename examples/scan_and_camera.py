"""Lidar, images, depth and point clouds as numpy arrays."""

import numpy as np
from _robot import robot

with robot() as chassis:
    scan = chassis.scan.wait(timeout=5)
    print(f"{scan.ranges.size} rays, nearest obstacle {scan.nearest:.2f} m, points {scan.points().shape}")
    print("colour", chassis.camera.wait(timeout=5).pixels.shape)
    print(f"depth up to {np.nanmax(chassis.depth.wait(timeout=5).depth_metres()):.2f} m")
    print("cloud", chassis.points.wait(timeout=5).points.shape)
