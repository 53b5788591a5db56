"""Definitions of rosauth."""
