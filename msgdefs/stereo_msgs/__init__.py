"""Definitions of stereo_msgs."""
