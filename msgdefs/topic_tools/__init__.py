"""Definitions of topic_tools."""
