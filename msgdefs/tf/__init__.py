"""Definitions of tf."""
