"""Definitions of actionlib_msgs."""
