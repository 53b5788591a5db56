"""The robot's application interface, the Robot API: JSON over HTTP and WebSocket on port 5480.

`wire` has its messages. The names and numbers of all types are in `data/robot_api.json`.
"""

from __future__ import annotations

__all__: list[str] = []
