"""Publish transforms to /tf and /tf_static, and fill a transform buffer from them.

Source: tf2_ros transform_broadcaster.py, static_transform_broadcaster.py, transform_listener.py; REP 105.
"""

from __future__ import annotations

import threading
from typing import Any, TypeVar

from rosproto.codec import DynamicMessage, message_class
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.tf.buffer import TransformBuffer, checked
from rosproto.tf.transform import StampedMessage, Transform

logger = get_logger("rosproto.tf")
MAX_NAMED = 1000  # frames whose first refusal is logged; a hostile sender may invent names


class TransformListener:
    """Subscribes to /tf and /tf_static and adds the transforms to `buffer`.

    The subscribers' threads fill the buffer. Invalid transforms (names, numbers) are counted, and the first
    of each frame is logged. When simulated time jumps back, moving frames are forgotten.

    Args:
        node: The node that subscribes.
        buffer: The buffer to fill; a new one by default.
        queue_size: Most messages of /tf that wait; older ones are dropped.

    Attributes:
        buffer: The buffer.
        refused: Number of invalid transforms so far.
    """

    def __init__(self, node: Node, buffer: TransformBuffer | None = None, *, queue_size: int = 100) -> None:
        self.buffer = buffer if buffer is not None else TransformBuffer()
        self.refused = 0
        self._node = node
        self._lock = threading.Lock()
        self._named: set[str] = set()
        self._newest = 0.0
        ours = message_class("tf2_msgs/TFMessage")  # not one of the user's folders
        self._subscribers = [
            node.subscriber("/tf", ours, callback=self._moving, queue_size=queue_size),
            node.subscriber("/tf_static", ours, callback=self._static, queue_size=queue_size),
        ]

    def __enter__(self) -> TransformListener:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def _moving(self, message: DynamicMessage) -> None:
        self._notice_jump()
        self._take(message, static=False)

    def _static(self, message: DynamicMessage) -> None:
        self._take(message, static=True)

    def _notice_jump(self) -> None:
        """As tf2_ros does: after the clock jumped back, all known poses would be newer than any to come."""
        with self._lock:  # around the reading, too: each publisher has a thread
            now = self._node.clock.now().to_sec()
            jumped, self._newest = now < self._newest - 1.0, now
        if jumped:
            logger.warning("time jumped back: clearing the transform buffer")
            self.buffer.clear()

    def _take(self, message: DynamicMessage, *, static: bool) -> None:
        authority = (message._connection_header or {}).get("callerid", "")
        for transform in message.transforms:
            try:
                self.buffer.set_transform(transform, authority=authority, static=static)
            except ValueError as error:
                self._refuse(transform.child_frame_id, authority, error)

    def _refuse(self, child: str, authority: str, error: ValueError) -> None:
        with self._lock:
            self.refused += 1
            child = child[:100]
            if child in self._named or len(self._named) >= MAX_NAMED:
                return
            self._named.add(child)
        logger.warning("transform of %s from %s is rejected: %s", child, authority, error)

    def close(self) -> None:
        """End both subscriptions; the buffer stays. May be called again."""
        for subscriber in self._subscribers:
            subscriber.close()


_Self = TypeVar("_Self", bound="_Broadcaster")


def _message(transform: Transform | StampedMessage) -> DynamicMessage:
    """A valid TransformStamped, from one or from a Transform.

    Raises:
        ValueError: Names or numbers are invalid, or the frame is its own parent.
    """
    value = transform if isinstance(transform, Transform) else Transform.from_message(transform)
    checked(value)
    message: DynamicMessage = value.to_message()
    return message


class _Broadcaster:
    """Base of both broadcasters: a topic of TFMessage, published until it is closed."""

    def __init__(self, node: Node, topic: str, **options: Any) -> None:
        self._class = message_class("tf2_msgs/TFMessage")
        self._publisher = node.publisher(topic, self._class, **options)

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop publishing; new subscribers get nothing. May be called again."""
        self._publisher.close()


class TransformBroadcaster(_Broadcaster):
    """Publishes poses of moving frames; call `send` for each new pose.

    Args:
        node: The node that publishes.
        queue_size: Most messages that wait for a slow subscriber; older ones are dropped.
    """

    def __init__(self, node: Node, *, queue_size: int = 100) -> None:
        super().__init__(node, "/tf", queue_size=queue_size)

    def send(self, *transforms: Transform | StampedMessage) -> None:
        """Send one message with these `Transform`s or geometry_msgs/TransformStamped, each with its stamp.

        Raises:
            ValueError: One of them is invalid; nothing is sent.
        """
        self._publisher.publish(self._class(transforms=[_message(transform) for transform in transforms]))


class StaticTransformBroadcaster(_Broadcaster):
    """Publishes poses of frames that never move, once; later subscribers get them, too (latched).

    A latched topic keeps only the last message, so each message contains every frame sent so far; sending a
    frame again replaces it. Use one broadcaster per node.
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node, "/tf_static", latch=True, queue_size=10)
        self._lock = threading.Lock()
        self._sent: dict[str, DynamicMessage] = {}

    def send(self, *transforms: Transform | StampedMessage) -> None:
        """Add or replace frames: `Transform`s or geometry_msgs/TransformStamped.

        Raises:
            ValueError: One of them is invalid; nothing is sent.
        """
        messages = [_message(transform) for transform in transforms]
        with self._lock:
            self._sent.update({message.child_frame_id: message for message in messages})
            self._publisher.publish(self._class(transforms=list(self._sent.values())))
