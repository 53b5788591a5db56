"""Definitions of rosapi."""
