"""Definitions of dynamic_reconfigure."""
