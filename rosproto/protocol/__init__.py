"""Protocols without I/O: bytes in, events out (wiki.ros.org/ROS/TCPROS, Master_API, Slave_API).

Each module is one protocol and is imported by its own name.
"""

from __future__ import annotations

__all__: list[str] = []
