"""Publishes log records on /rosout.

The records of `node.logger`, and of any logger with `Rosout.handler`, are published as rosgraph_msgs/Log,
latched, as by rospy and roscpp. The library's own records are not published: a record about /rosout on
/rosout would loop for ever.

Every ROS node has the services ~get_loggers and ~set_logger_level for its log levels. Python's loggers
belong to the process, so all nodes of a process give the same answers. Levels change only by the service,
which refuses unknown names, since Python never frees a logger.

Source: wiki.ros.org/rosout; rospy impl/rosout.py; roscpp/GetLoggers.srv, roscpp/SetLoggerLevel.srv; rospy
client.py `_get_loggers`.
"""

from __future__ import annotations

import itertools
import logging
import threading
from collections.abc import Callable

from rosproto.codec import DynamicMessage, ServiceType, message_class, service_class
from rosproto.errors import ServiceError
from rosproto.node.clock import NodeClock
from rosproto.node.outgoing.publisher import Publisher
from rosproto.node.services.server import ServiceServer
from rosproto.node.shutdown import Lifecycle
from rosproto.text import near_names

_TABLE = (
    # name, rosgraph_msgs/Log, logging
    ("debug", 1, 10),
    ("info", 2, 20),
    ("warn", 4, 30),
    ("error", 8, 40),
    ("fatal", 16, 50),
)

LEVELS = {name: python for name, _, python in _TABLE}
"""Name -> level of `logging`."""


def ros_level(levelno: int) -> tuple[str, int]:
    """ROS's name and rosgraph_msgs/Log of a level of `logging`: the highest not above it, else debug."""
    return next(((name, ros) for name, ros, python in reversed(_TABLE) if levelno >= python), _TABLE[0][:2])


ROOT = "root"


def logger_names() -> list[str]:
    """Names of the root logger and, sorted, of all loggers in use."""
    made = logging.root.manager.loggerDict.items()
    return [ROOT, *sorted(name for name, entry in list(made) if isinstance(entry, logging.Logger))]


def _logger(name: str) -> logging.Logger:
    return logging.getLogger(None if name in (ROOT, "") else name)


def set_level(name: str, level: str) -> None:
    """Set a logger to a level of ROS ("debug" to "fatal").

    Raises:
        ValueError: There is no such level or logger; the text lists the levels or similar names.
    """
    value = LEVELS.get(level.strip().lower())
    if value is None:
        raise ValueError(f"level {level!r} is not one of {', '.join(LEVELS)}")
    names = logger_names()
    if name and name not in names:
        near = near_names(name, names)
        raise ValueError(f"no logger {name!r}{'; near: ' + ', '.join(near) if near else ''}")
    _logger(name).setLevel(value)


class LoggerServices:
    """Provides both services for one node until the node closes.

    Args:
        provide: `Node.service_server`.
    """

    def __init__(
        self, provide: Callable[[str, type[ServiceType], Callable[[DynamicMessage], object]], ServiceServer]
    ) -> None:
        self._entry = message_class("roscpp/Logger")
        self._servers = [
            provide("~get_loggers", service_class("roscpp/GetLoggers"), self._get),
            provide("~set_logger_level", service_class("roscpp/SetLoggerLevel"), self._set),
        ]

    def _get(self, request: object) -> dict[str, object]:
        return {
            "loggers": [
                self._entry(name=name, level=ros_level(_logger(name).getEffectiveLevel())[0])
                for name in logger_names()
            ]
        }

    @staticmethod
    def _set(request: DynamicMessage) -> None:
        try:
            set_level(request.logger, request.level)
        except ValueError as error:
            raise ServiceError("set_logger_level", str(error)) from None

    def close(self) -> None:
        """Close both services. May be called again."""
        for server in self._servers:
            server.close()


OWN = "rosproto"


class _Handler(logging.Handler):
    """Publishes records, with their formatted text."""

    def __init__(self, publish: Callable[[logging.LogRecord, str], None]) -> None:
        super().__init__()
        self._publish = publish

    def emit(self, record: logging.LogRecord) -> None:
        """Publish one record; errors are handled by `logging` (`raiseExceptions`)."""
        try:
            self._publish(record, self.format(record))
        except Exception:
            self.handleError(record)


class Rosout:
    """Publisher of /rosout for one node.

    Args:
        name: Name of the node.
        logger: Its logger.
        clock: Gives the time stamps.
        lifecycle: Publishing stops once the node is closing.
        publish: `Node.publisher`.
        topics: Lists the node's topics, for every record; None leaves them out.

    Attributes:
        handler: Publishes its records; may be added to any logger. The node's logger has it.
    """

    def __init__(
        self,
        name: str,
        logger: logging.Logger,
        clock: NodeClock,
        lifecycle: Lifecycle,
        publish: Callable[..., Publisher],
        topics: Callable[[], list[list[str]]] | None = None,
    ) -> None:
        self._name = name
        self._logger = logger
        self._clock = clock
        self._lifecycle = lifecycle
        self._log_class = message_class("rosgraph_msgs/Log")
        self._seq = itertools.count(1)
        self._busy = threading.local()
        self._topics = topics
        self._publisher = publish("/rosout", self._log_class, latch=True, queue_size=100)
        self.handler = _Handler(self.publish)
        lifecycle.closers.append(self._close)
        logger.addHandler(self.handler)

    def publish(self, record: logging.LogRecord, text: str) -> None:
        """Publish one record; skip records logged meanwhile in the same thread (no loops)."""
        if getattr(self._busy, "now", False) or record.name.split(".")[0] == OWN or self._lifecycle.closed:
            return
        self._busy.now = True
        try:
            self._publisher.publish(self._message(record, text))
        finally:
            self._busy.now = False

    def _message(self, record: logging.LogRecord, text: str) -> DynamicMessage:
        message = self._log_class()
        message.header.stamp = self._clock.now()
        _, message.level = ros_level(record.levelno)
        message.name = self._name
        message.msg = text
        message.file = record.filename
        message.function = record.funcName or ""
        message.line = record.lineno
        if self._topics is not None:
            message.topics = [name for name, _ in self._topics()]
        return message

    def _close(self) -> None:
        self._logger.removeHandler(self.handler)
