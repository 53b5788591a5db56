"""Definitions of actionlib."""
