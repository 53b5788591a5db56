"""Definitions of smach_msgs."""
