"""Definitions of woosh_msgs."""
