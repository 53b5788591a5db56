"""Transforms between frames over time (tf2): a buffer, and the listener and broadcasters of a node.

    buffer = tf.TransformBuffer()
    with tf.TransformListener(node, buffer):
        map_T_base = buffer.lookup("map", "base_link", timeout=2.0)

Source: wiki.ros.org/tf2, REP 105.
"""

from rosproto.tf.buffer import (
    ExtrapolationError,
    NotConnected,
    TransformBuffer,
    TransformError,
    UnknownFrame,
)
from rosproto.tf.topics import StaticTransformBroadcaster, TransformBroadcaster, TransformListener
from rosproto.tf.transform import Transform
from rosproto.tf.tree import History, Sample

__all__ = [
    "ExtrapolationError",
    "History",
    "NotConnected",
    "Sample",
    "StaticTransformBroadcaster",
    "Transform",
    "TransformBroadcaster",
    "TransformBuffer",
    "TransformError",
    "TransformListener",
    "UnknownFrame",
]
