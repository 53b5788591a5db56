"""Definitions of trajectory_msgs."""
