"""Definitions of map_msgs."""
