"""Publish transforms to /tf and /tf_static.

Source: tf2_ros transform_broadcaster.py, static_transform_broadcaster.py; REP 105.
"""

from __future__ import annotations

import threading
from typing import Any, TypeVar

from rosproto.codec import message_class
from rosproto.node import Node
from rosproto.tf.buffer import checked
from rosproto.tf.transform import Transform

_Self = TypeVar("_Self", bound="_Broadcaster")


def _message(transform: Transform | Any) -> Any:
    """A valid TransformStamped, from one or from a Transform.

    Raises:
        ValueError: Names or numbers are invalid, or the frame is its own parent.
    """
    value = transform if isinstance(transform, Transform) else Transform.from_message(transform)
    checked(value)
    return value.to_message()


class _Broadcaster:
    """Base of both broadcasters: a topic of TFMessage, published until it is closed."""

    def __init__(self, node: Node, topic: str, **options: Any) -> None:
        self._class: Any = message_class("tf2_msgs/TFMessage")
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

    def send(self, *transforms: Transform | Any) -> None:
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
        self._sent: dict[str, Any] = {}

    def send(self, *transforms: Transform | Any) -> None:
        """Add or replace frames: `Transform`s or geometry_msgs/TransformStamped.

        Raises:
            ValueError: One of them is invalid; nothing is sent.
        """
        messages = [_message(transform) for transform in transforms]
        with self._lock:
            self._sent.update({message.child_frame_id: message for message in messages})
            self._publisher.publish(self._class(transforms=list(self._sent.values())))
