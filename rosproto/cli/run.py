"""`rosproto run`: a program written for rospy, unchanged, without ROS."""

from __future__ import annotations

from rosproto.rospy.launch import add_arguments, run

__all__ = ["add_arguments", "run"]
