"""Definitions of tf2_web_republisher."""
