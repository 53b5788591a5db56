"""Definitions of move_base_msgs."""
