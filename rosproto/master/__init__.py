"""A ROS master: registry and parameter tree (pure), the Master API over them, and the server."""

from __future__ import annotations

from .api import MasterApi
from .notifications import Notification, ParamUpdate, PublisherUpdate
from .parameters import ParameterTree
from .registry import Registry
from .server import Master

__all__ = [
    "Master",
    "MasterApi",
    "Notification",
    "ParamUpdate",
    "ParameterTree",
    "PublisherUpdate",
    "Registry",
]
