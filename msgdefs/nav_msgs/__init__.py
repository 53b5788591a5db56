"""Definitions of nav_msgs."""
