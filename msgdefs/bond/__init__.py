"""Definitions of bond."""
