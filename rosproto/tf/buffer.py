"""`TransformBuffer`: thread-safe lookups, with waiting, over a `FrameTree` (rosproto/tf/tree.py); its errors.

Source: tf2 buffer_core.cpp; REP 105 (frame names), wiki.ros.org/tf2.
"""

from __future__ import annotations

import math
import threading
from typing import Any, NoReturn

from rosproto.errors import RosError, RosTimeout
from rosproto.quaternion import normalized
from rosproto.text import near_names
from rosproto.tf.transform import StampedMessage, Transform, nanoseconds
from rosproto.tf.tree import (
    MAX_FRAMES,
    MAX_NAME_CHARACTERS,
    MAX_SAMPLES,
    FrameLoop,
    FrameTree,
    History,
    PoseUnknown,
    Sample,
    SeparateTrees,
)
from rosproto.time import TVal
from rosproto.transport.deadline import Deadline

UNIT_TOLERANCE = 1e-2  # as in tf2: the squared length of a rotation may differ by this from 1


def frame_name(name: str) -> str:
    """The frame's name without a leading slash: tf2 has none, but old programs still send them.

    Raises:
        ValueError: The name is empty or too long.
    """
    stripped = name.lstrip("/")
    if not stripped:
        raise ValueError("a frame name is empty")
    if len(stripped) > MAX_NAME_CHARACTERS:
        raise ValueError(f"a frame name has {len(stripped)} characters, more than {MAX_NAME_CHARACTERS}")
    return stripped


class TransformBuffer:
    """The transforms of a robot. Thread-safe.

    Attributes:
        cache_time: Seconds for which the poses of a frame are kept.

    Args:
        max_frames: Most frames; further ones are refused.
        max_samples: Most poses of each frame.
    """

    def __init__(
        self, cache_time: float = 10.0, *, max_frames: int = MAX_FRAMES, max_samples: int = MAX_SAMPLES
    ) -> None:
        self.cache_time = cache_time
        self._cache_ns = round(cache_time * 1e9)
        self._max_frames = max_frames
        self._max_samples = max_samples
        self._tree = FrameTree(max_frames)
        self._changed = threading.Condition()

    def set_transform(
        self, transform: Transform | StampedMessage, *, authority: str = "", static: bool = False
    ) -> bool:
        """Add one pose of a frame in its parent.

        Args:
            transform: A `Transform` or a geometry_msgs/TransformStamped.
            authority: The sender, for `frames()`.
            static: True if it holds at all times.

        Returns:
            False if it is older than the cache or its stamp is already known.

        Raises:
            ValueError: Names or numbers are invalid, or the frame is its own parent.
        """
        if not isinstance(transform, Transform):
            transform = Transform.from_message(transform)
        child, sample = frame_name(transform.source), checked(transform)
        with self._changed:
            edge = self._edge(child, static)
            edge.authority = authority
            taken = edge.add(sample) is None
            self._tree.remember_names(child, sample.parent)
            self._changed.notify_all()
        return taken

    def _edge(self, child: str, static: bool) -> History:
        """A frame's history; a new one if the frame is new, or changes between moving and static."""
        edges = self._tree.edges
        edge = edges.get(child)
        if not self._tree.has_room(child):
            raise ValueError(f"{child}: {self._max_frames} frames are known already, which is the limit")
        if edge is None or edge.static != static:
            edge = edges[child] = History(self._cache_ns, self._max_samples, static=static)
        return edge

    def lookup(
        self,
        target: str,
        source: str,
        time: TVal | float | None = None,
        timeout: float | None = 0.0,
    ) -> Transform:
        """The transform that converts coordinates in `source` to coordinates in `target`.

        Args:
            target: Frame of the result ("map").
            source: Frame of the data ("base_link"); the result is the pose of `source` in `target`.
            time: A Time or seconds; None (or zero) for the latest time at which the whole path is known.
            timeout: Seconds to wait for the transform; None waits for ever.

        Raises:
            UnknownFrame, NotConnected, ExtrapolationError: There is no transform (within `timeout`).
        """
        target, source, moment = frame_name(target), frame_name(source), nanoseconds(time)
        deadline = Deadline(timeout)
        with self._changed:
            while True:
                try:
                    return self._lookup(target, source, moment)
                except TransformError:
                    if deadline.expired:
                        raise
                    self._changed.wait(deadline.remaining())

    def lookup_full(
        self,
        target: str,
        target_time: TVal | float | None,
        source: str,
        source_time: TVal | float | None,
        fixed: str,
        timeout: float | None = 0.0,
    ) -> Transform:
        """From `source` at one time to `target` at another, via a frame that did not move in between."""
        there = self.lookup(fixed, source, source_time, timeout)
        back = self.lookup(target, fixed, target_time, timeout)
        whole = back @ there
        return Transform(whole.target, whole.source, whole.translation, whole.rotation, back.stamp_ns)

    def can_lookup(self, target: str, source: str, time: TVal | float | None = None) -> bool:
        """Whether `lookup` would succeed now."""
        try:
            self.lookup(target, source, time)
        except TransformError:
            return False
        return True

    def wait(self, target: str, source: str, timeout: float | None = 5.0) -> None:
        """Wait until any transform between two frames is known.

        Raises:
            RosTimeout: It is not known in time; the text says what was missing.
        """
        try:
            self.lookup(target, source, None, timeout)
        except TransformError as error:
            raise RosTimeout(
                f"no transform within {timeout} s: {error}", what=f"{target} <- {source}", seconds=timeout
            ) from error

    def frames(self) -> dict[str, dict[str, Any]]:
        """Every known child frame: its parent, authority, static, earliest and latest (s), samples."""
        with self._changed:
            return {
                child: {
                    "parent": edge.newest.parent,
                    "authority": edge.authority,
                    "static": edge.static,
                    "earliest": edge.earliest / 1e9,
                    "latest": edge.newest.stamp / 1e9,
                    "samples": len(edge),
                }
                for child, edge in self._tree.edges.items()
            }

    def clear(self) -> None:
        """Forget the moving frames, as after a backward jump of the clock; static ones stay."""
        with self._changed:
            edges = self._tree.edges
            self._tree.edges = {child: edge for child, edge in edges.items() if edge.static}
            self._tree.drop_former_parents()

    def _lookup(self, target: str, source: str, moment: int) -> Transform:
        if target != source:
            self._require(target, source)
        try:
            (translation, rotation), moment = self._tree.lookup(target, source, moment)
        except PoseUnknown as gap:
            self._pose_unknown(target, source, gap)
        except SeparateTrees as two:
            raise NotConnected(
                f"not connected: {target} hangs below {two.target_root}, {source} below {two.source_root};"
                " no transform between these two is published",
                target=target,
                source=source,
                target_root=two.target_root,
                source_root=two.source_root,
            ) from None
        except FrameLoop:
            raise NotConnected(
                "the path to the root contains a loop of frames that are each other's parents; see frames()",
                target=target,
                source=source,
            ) from None
        return Transform(target, source, translation, rotation, moment)

    def _require(self, target: str, source: str) -> None:
        for frame in (target, source):
            if frame in self._tree.names:
                continue
            near = near_names(frame, self._tree.names) or sorted(self._tree.names)[:10]
            hint = f"; known are {', '.join(near)}" if near else "; no frame has been published yet"
            raise UnknownFrame(f"frame {frame!r} is unknown{hint}", frame=frame, target=target, source=source)

    @staticmethod
    def _pose_unknown(target: str, source: str, gap: PoseUnknown) -> NoReturn:
        child, edge = gap.child, gap.history
        asked, first, last = gap.stamp / 1e9, edge.earliest / 1e9, edge.newest.stamp / 1e9
        if asked > last:
            how = f"{asked - last:.6g} s in the future; wait with timeout=, or take the latest (time=None)"
        elif asked < first:
            how = f"{first - asked:.6g} s in the past; it is forgotten or was never sent"
        else:
            how = "between two parents"
        known = f"known from {first:.6f} to {last:.6f} s" if len(edge) > 1 else f"known at {last:.6f} s only"
        raise ExtrapolationError(
            f"at {asked:.6f} s: {edge.newest.parent} -> {child} is {known}, and this is {how}",
            target=target,
            source=source,
            parent=edge.newest.parent,
            child=child,
            requested=asked,
            earliest=first,
            latest=last,
        ) from None


def checked(transform: Transform) -> Sample:
    parent, child = frame_name(transform.target), frame_name(transform.source)
    if parent == child:
        raise ValueError(f"frame {child} is published as its own parent")
    numbers = (*transform.translation, *transform.rotation)
    if not all(map(math.isfinite, numbers)):
        raise ValueError(f"{parent} -> {child}: {numbers} are not all finite")
    square = sum(part * part for part in transform.rotation)
    if abs(square - 1) > UNIT_TOLERANCE:
        raise ValueError(f"{parent} -> {child}: the rotation has length {math.sqrt(square):.6g}, expected 1")
    return Sample(transform.stamp_ns, parent, transform.translation, normalized(transform.rotation))


class TransformError(RosError, LookupError):
    """There is no such transform.

    Attributes:
        target: Frame requested.
        source: Frame of the data.
    """

    def __init__(self, message: str, *, target: str = "", source: str = "") -> None:
        super().__init__(f"{target} <- {source}: {message}" if target else message)
        self.target = target
        self.source = source


class UnknownFrame(TransformError):
    """The frame has not been published.

    Attributes:
        frame: The frame.
    """

    def __init__(self, message: str, *, frame: str, target: str = "", source: str = "") -> None:
        super().__init__(message, target=target, source=source)
        self.frame = frame


class NotConnected(TransformError):
    """Both frames are known, but belong to separate trees.

    Attributes:
        target_root, source_root: The root of each tree.
    """

    def __init__(
        self,
        message: str,
        *,
        target: str = "",
        source: str = "",
        target_root: str = "",
        source_root: str = "",
    ) -> None:
        super().__init__(message, target=target, source=source)
        self.target_root = target_root
        self.source_root = source_root


class ExtrapolationError(TransformError):
    """The requested time is outside the known range.

    Attributes:
        parent, child: The edge of the tree that is unknown at that time.
        requested: Requested time, seconds.
        earliest, latest: Known range of that edge, seconds.
    """

    def __init__(
        self,
        message: str,
        *,
        target: str = "",
        source: str = "",
        parent: str = "",
        child: str = "",
        requested: float = 0.0,
        earliest: float = 0.0,
        latest: float = 0.0,
    ) -> None:
        super().__init__(message, target=target, source=source)
        self.parent = parent
        self.child = child
        self.requested = requested
        self.earliest = earliest
        self.latest = latest
