"""Definitions of geometry_msgs."""
