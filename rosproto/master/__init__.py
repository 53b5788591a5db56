"""A ROS master: registry and parameter tree (pure), and the server around them."""

from __future__ import annotations

from .api import MasterApi
from .notifications import Notification, ParamUpdate, PublisherUpdate, Shutdown
from .notifier import Notifier
from .parameters import ParameterTree
from .registry import Answer, Registry
from .server import DEFAULT_PORT, Master

__all__ = [
    "DEFAULT_PORT",
    "Answer",
    "Master",
    "MasterApi",
    "Notification",
    "Notifier",
    "ParamUpdate",
    "ParameterTree",
    "PublisherUpdate",
    "Registry",
    "Shutdown",
]
