"""laser_geometry: LaserScan messages as point clouds (wiki.ros.org/laser_geometry)."""

from .laser_geometry import LaserProjection

__all__ = ["LaserProjection"]
