"""The vendor's C++ footprint example: tell the navigation that the robot carries something."""

from _robot import robot

CORNERS = [(-0.4, 0.253), (-0.353, 0.3), (0.353, 0.3), (0.4, 0.253)]
CORNERS += [(-x, -y) for x, y in CORNERS]

with robot() as chassis:
    outline = chassis.set_footprint(CORNERS, padding=0.1)
    print(
        f"sent to both costmaps: {len(outline.points)} corners, radius {outline.circumscribed_radius:.2f} m"
    )
