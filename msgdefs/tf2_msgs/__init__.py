"""Definitions of tf2_msgs."""
