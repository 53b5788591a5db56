"""Definitions of control_msgs."""
