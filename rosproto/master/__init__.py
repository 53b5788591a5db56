"""A ROS master: registry and parameter tree (pure), the Master API over them, and the server."""

from __future__ import annotations

from rosproto.master.api import MasterApi
from rosproto.master.notifications import Notification, ParamUpdate, PublisherUpdate
from rosproto.master.parameters import ParameterTree
from rosproto.master.registry import Registry
from rosproto.master.server import Master

__all__ = [
    "Master",
    "MasterApi",
    "Notification",
    "ParamUpdate",
    "ParameterTree",
    "PublisherUpdate",
    "Registry",
]
