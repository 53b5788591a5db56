"""Definitions of std_srvs."""
