"""The services every ROS node has for its log levels: ~get_loggers and ~set_logger_level.

Python's loggers belong to the process, so all nodes of a process answer alike. A level is changed only when
somebody asks for it by the service; names that no program uses are refused, since a logger once made is
never freed.

Source: roscpp/GetLoggers.srv, roscpp/SetLoggerLevel.srv; rospy client.py `_get_loggers`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosproto.codec import message_class, service_class
from rosproto.errors import ServiceError
from rosproto.node.rosout.levels import LEVELS, level_name
from rosproto.node.services.server import ServiceServer

if TYPE_CHECKING:
    import logging


ROOT = "root"


def logger_names() -> list[str]:
    """The root logger and every logger that a program has asked for, sorted."""
    import logging

    made = logging.root.manager.loggerDict.items()
    return [ROOT, *sorted(name for name, entry in list(made) if isinstance(entry, logging.Logger))]


def _logger(name: str) -> logging.Logger:
    import logging

    return logging.getLogger(None if name in (ROOT, "") else name)


def set_level(name: str, level: str) -> None:
    """Set the level of a logger by ROS's name of it.

    Raises:
        ValueError: There is no such level or logger; the text lists what there is.
    """
    value = LEVELS.get(level.strip().lower())
    if value is None:
        raise ValueError(f"level {level!r} is none of {', '.join(LEVELS)}")
    names = logger_names()
    if name and name not in names:
        import difflib

        near = difflib.get_close_matches(name, names, 3)
        raise ValueError(f"no logger {name!r}{'; near: ' + ', '.join(near) if near else ''}")
    _logger(name).setLevel(value)


class Loggers:
    """Provides both services for one node until the node closes.

    Args:
        provide: `Node.service_server`.
    """

    def __init__(self, provide: Callable[[str, Any, Callable[[Any], Any]], ServiceServer]) -> None:
        self._entry: Any = message_class("roscpp/Logger")
        self._servers = [
            provide("~get_loggers", service_class("roscpp/GetLoggers"), self._get),
            provide("~set_logger_level", service_class("roscpp/SetLoggerLevel"), self._set),
        ]

    def _get(self, request: Any) -> dict[str, Any]:
        return {
            "loggers": [
                self._entry(name=name, level=level_name(_logger(name).getEffectiveLevel()))
                for name in logger_names()
            ]
        }

    @staticmethod
    def _set(request: Any) -> None:
        try:
            set_level(request.logger, request.level)
        except ValueError as error:
            raise ServiceError("set_logger_level", str(error)) from None

    def close(self) -> None:
        """Withdraw both. May be called again."""
        for server in self._servers:
            server.close()
