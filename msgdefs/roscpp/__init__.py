"""Definitions of roscpp."""
