"""Definitions of visualization_msgs."""
