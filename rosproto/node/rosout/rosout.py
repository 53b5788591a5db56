"""/rosout: log records go out as messages, and messages of other nodes come in as log records.

Out: `node.logger` (and any logger the program adds `Rosout.handler` to) is published as rosgraph_msgs/Log,
latched, as rospy and roscpp do. In: `log_messages` subscribes /rosout and feeds a logger. The library's own
records are not published: a record about /rosout on /rosout would go round for ever (pitfall 61).

`logging` is not imported for this: the handler is put on `node.logger` when the program asks for that, when
`logging` is there already, or within a second of its import (the watchdog looks).

Source: wiki.ros.org/rosout; rospy impl/rosout.py.
"""

from __future__ import annotations

import itertools
import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from rosproto.codec import message_class
from rosproto.node.context import Context
from rosproto.node.incoming.subscriber import Subscriber
from rosproto.node.outgoing.publisher import Publisher
from rosproto.node.revisions.topic_types import TypeGiven
from rosproto.node.rosout.levels import python_level, ros_level

if TYPE_CHECKING:
    import logging


OWN = "rosproto"


class Subscribes(Protocol):
    """A `Node`, as far as it is needed here."""

    @property
    def name(self) -> str: ...

    def subscriber(
        self, topic: str, type: TypeGiven, callback: Callable[[Any], object], *, queue_size: int
    ) -> Subscriber: ...


class Rosout:
    """Publisher of /rosout for one node.

    Args:
        context: Of the node.
        publish: `Node.publisher`.
        topics: Lists the node's topics, for every record; None leaves them out.
    """

    def __init__(
        self,
        context: Context,
        publish: Callable[..., Publisher],
        topics: Callable[[], list[list[str]]] | None = None,
    ) -> None:
        self._context = context
        self._log_class = message_class("rosgraph_msgs/Log")
        self._seq = itertools.count(1)
        self._busy = threading.local()
        self._topics = topics
        self._publisher = publish("/rosout", self._log_class, latch=True, queue_size=100)
        self._handler: logging.Handler | None = None
        self._attaching = threading.Lock()
        context.closers.append(self._close)
        self.attach_if_used()

    @property
    def handler(self) -> logging.Handler:
        """Publishes what it handles; add it to any logger. The node's own has it from now on."""
        with self._attaching:
            if self._handler is None:
                from rosproto.node.rosout.handler import RosoutHandler

                self._handler = RosoutHandler(self.publish)
                if not self._context.closed:
                    self._context.logger.addHandler(self._handler)
            return self._handler

    def attach_if_used(self) -> None:
        """Have the node's logger publish, if the program has imported `logging`: nobody can log before."""
        if self._handler is None and "logging" in sys.modules:
            _ = self.handler

    def publish(self, record: logging.LogRecord, text: str) -> None:
        """Send one record; one that arises meanwhile in the same thread is not sent (no loops)."""
        if getattr(self._busy, "now", False) or record.name.split(".")[0] == OWN or self._context.closed:
            return
        self._busy.now = True
        try:
            self._publisher.publish(self._message(record, text))
        finally:
            self._busy.now = False

    def _message(self, record: logging.LogRecord, text: str) -> Any:
        message: Any = self._log_class()
        message.header.stamp = self._context.clock.now()
        message.level = ros_level(record.levelno)
        message.name = self._context.name
        message.msg = text
        message.file = record.filename
        message.function = record.funcName or ""
        message.line = record.lineno
        if self._topics is not None:
            message.topics = [name for name, _ in self._topics()]
        return message

    def _close(self) -> None:
        with self._attaching:
            if self._handler is not None:
                self._context.logger.removeHandler(self._handler)


def log_messages(node: Subscribes, logger: logging.Logger, *, topic: str = "/rosout") -> Subscriber:
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

    return node.subscriber(topic, message_class("rosgraph_msgs/Log"), forward, queue_size=100)
