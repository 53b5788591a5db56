"""/rosout: log records go out as messages, and messages of other nodes come in as log records.

Out: `node.logger` (and any logger the program adds `Rosout.handler` to) is published as rosgraph_msgs/Log,
latched, as rospy and roscpp do. In: `log_messages` subscribes /rosout and feeds a logger. The library's own
records are not published: a record about /rosout on /rosout would go round for ever (pitfall 61).

Source: wiki.ros.org/rosout; rospy impl/rosout.py.
"""

from __future__ import annotations

import itertools
import logging
import threading
from typing import TYPE_CHECKING, Any

from rosproto.codec import message_class

if TYPE_CHECKING:
    from rosproto.node.node import Node
    from rosproto.node.subscriber import Subscriber

__all__ = ["LEVELS", "Rosout", "log_messages"]

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16
LEVELS = {
    "debug": logging.DEBUG,
    "info": logging.INFO,
    "warn": logging.WARNING,
    "error": logging.ERROR,
    "fatal": logging.CRITICAL,
}
"""Level names of roscpp/SetLoggerLevel."""

OWN = "rosproto"


class Rosout:
    """Publisher of /rosout for one node.

    Attributes:
        handler: A `logging.Handler`; add it to any logger.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._log_class = message_class("rosgraph_msgs/Log")
        self._seq = itertools.count(1)
        self._busy = threading.local()
        self._with_topics = self._asks_for_topics()
        self._publisher = node.publisher("/rosout", self._log_class, latch=True, queue_size=100)
        self.handler = _Handler(self)
        node.logger.addHandler(self.handler)
        node._closers.append(self._close)

    def _asks_for_topics(self) -> bool:
        """The list of topics in every record can be switched off for the whole graph."""
        try:
            return not self._node.master.get_param("/rosout_disable_topics_generation")
        except Exception:
            return True  # not set, or the master is away: the default holds

    def publish(self, record: logging.LogRecord, text: str) -> None:
        """Send one record; one that arises meanwhile in the same thread is not sent (no loops)."""
        if getattr(self._busy, "now", False) or record.name.split(".")[0] == OWN or self._node.closed:
            return
        self._busy.now = True
        try:
            self._publisher.publish(self._message(record, text))
        finally:
            self._busy.now = False

    def _message(self, record: logging.LogRecord, text: str) -> Any:
        message: Any = self._log_class()
        message.header.stamp = self._node.clock.now()
        message.level = ros_level(record.levelno)
        message.name = self._node.name
        message.msg = text
        message.file = record.filename
        message.function = record.funcName or ""
        message.line = record.lineno
        if self._with_topics:
            message.topics = [name for name, _ in self._node._topics.publications()]
        return message

    def _close(self) -> None:
        self._node.logger.removeHandler(self.handler)


class _Handler(logging.Handler):
    def __init__(self, rosout: Rosout) -> None:
        super().__init__()
        self._rosout = rosout

    def emit(self, record: logging.LogRecord) -> None:
        try:
            self._rosout.publish(record, self.format(record))
        except Exception:
            self.handleError(record)


def ros_level(levelno: int) -> int:
    """The level of rosgraph_msgs/Log for one of `logging`."""
    for limit, level in (
        (logging.CRITICAL, FATAL),
        (logging.ERROR, ERROR),
        (logging.WARNING, WARN),
        (logging.INFO, INFO),
    ):
        if levelno >= limit:
            return level
    return DEBUG


def python_level(level: int) -> int:
    """The level of `logging` for one of rosgraph_msgs/Log."""
    for limit, levelno in (
        (FATAL, logging.CRITICAL),
        (ERROR, logging.ERROR),
        (WARN, logging.WARNING),
        (INFO, logging.INFO),
    ):
        if level >= limit:
            return levelno
    return logging.DEBUG


def log_messages(node: Node, logger: logging.Logger, *, topic: str = "/rosout") -> Subscriber:
    """Feed the /rosout messages of all *other* nodes into a logger; close the subscriber to stop.

    Args:
        node: Subscribes for it.
        logger: Gets records with the sender's level; `record.ros_node` is its name. It must not have this
            node's own /rosout handler, or every message would be sent again: records of other nodes carry a
            mark and are left out there.
        topic: "/rosout_agg" is the aggregate of a running rosout node.
    """

    def forward(message: Any) -> None:
        if message.name == node.name:
            return
        level = python_level(message.level)
        if logger.isEnabledFor(level):
            record = logger.makeRecord(
                OWN + ".rosout", level, message.file, message.line, message.msg, (), None, message.function
            )
            record.ros_node = message.name
            logger.handle(record)

    return node.subscriber(topic, "rosgraph_msgs/Log", forward, queue_size=100)
