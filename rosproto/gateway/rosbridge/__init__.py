"""The rosbridge protocol, version 2, over a node: what roslibjs, roslibpy and others speak.

Source: ROSBRIDGE_PROTOCOL.md of rosbridge_suite.
"""

__all__: list[str] = []
