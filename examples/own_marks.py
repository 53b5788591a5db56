"""Marks cannot be listed over this interface: keep a list of your own."""

import tempfile
from pathlib import Path

from _robot import robot

from woosh_pure.maps import MarkFile

with robot() as chassis, tempfile.TemporaryDirectory() as directory:
    marks = MarkFile(Path(directory) / "marks.json")
    marks.put("start", chassis.pose.wait(timeout=5), note="where the robot was switched on")
    marks.put("A1", note="a mark of the chassis's own map")
    marks.save()
    print("known:", *MarkFile(marks.path).names)
    print(chassis.go_to_mark("A1").wait(timeout=60).sentence())
    home = marks["start"].pose
    assert home is not None  # "A1" has none: the chassis knows where that is
    print(chassis.go_to(home.x, home.y, home.yaw).wait(timeout=60).sentence())
