"""laser_geometry: LaserScan messages as clouds. Programs import the module inside, too, as in ROS."""

from .laser_geometry import LaserProjection
