"""Definitions of std_msgs."""
