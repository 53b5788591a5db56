"""A server of the rosbridge protocol, version 2, over a node: for roslibjs, roslibpy and others.

Source: ROSBRIDGE_PROTOCOL.md of rosbridge_suite.
"""

__all__: list[str] = []
