"""Definitions of shape_msgs."""
