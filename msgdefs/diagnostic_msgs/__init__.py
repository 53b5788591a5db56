"""Definitions of diagnostic_msgs."""
