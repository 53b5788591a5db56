"""Fetch the map, save it for map_server and as a picture, and give it back."""

import tempfile
from pathlib import Path

from _robot import robot

from woosh_pure import Pose2D
from woosh_pure.maps import GridMap

with robot() as chassis, tempfile.TemporaryDirectory() as directory:
    grid = chassis.get_map()
    print(f"{grid.width} x {grid.height} cells of {grid.resolution} m, {(grid.cells > 50).sum()} occupied")
    yaml_path, image = grid.save(Path(directory) / "hall")
    print("saved", yaml_path.name, image.name, grid.save_png(Path(directory) / "hall.png").name)
    chassis.set_map(GridMap.load(yaml_path), initial_pose=chassis.pose.wait(timeout=5))
    print("still at", chassis.pose.wait(timeout=5), "in a map of", Pose2D(0, 0).frame)
