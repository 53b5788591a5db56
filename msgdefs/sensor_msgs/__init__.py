"""Definitions of sensor_msgs."""
