"""A robot that has only the Robot API, as a ROS 1 graph in this process. Needs the extra `api`."""

from __future__ import annotations

from woosh_pure.api_bridge.bridge import ApiBridge

__all__ = ["ApiBridge"]
