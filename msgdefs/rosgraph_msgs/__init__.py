"""Definitions of rosgraph_msgs."""
