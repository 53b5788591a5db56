"""The frame tree and the history of each frame: the computation of all transform buffers.

Two frames are connected by their common root, or directly if one is below the other. Pure: no clock, no lock,
no waiting, no error texts. `TransformBuffer` and the rospy layer's tf2_py add these, and check names.

Source: tf2 buffer_core.cpp (walkToTopParent, getLatestCommonTime, lookupTransform).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import NamedTuple

from rosproto import quaternion
from rosproto.deprecation import former_parameters
from rosproto.quaternion import Quaternion, Vector, conjugate, multiply, rotate

MAX_FRAMES = 10_000
MAX_SAMPLES = 50_000  # of one frame
MAX_NAME_CHARACTERS = 1000  # characters
MAX_DEPTH = 1000  # as in tf2: a longer path to the root is a loop

Pose = tuple[Vector, Quaternion]
IDENTITY: Pose = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)


class NoPath(Exception):
    """There is no transform; buffers convert this to their own errors."""


class FrameLoop(NoPath):
    """The path to the root does not end."""


class SeparateTrees(NoPath):
    """The frames are in two trees, with these roots above the source and above the target."""

    def __init__(self, source_root: str, target_root: str) -> None:
        super().__init__(source_root, target_root)
        self.source_root = source_root
        self.target_root = target_root


class PoseUnknown(NoPath):
    """The pose of `child` is unknown at `stamp` (ns)."""

    def __init__(self, child: str, history: History, stamp: int) -> None:
        super().__init__(child, stamp)
        self.child = child
        self.history = history
        self.stamp = stamp


class FramePath(NamedTuple):
    """The pose of the source in the target, and the frames on each side below their common ancestor."""

    translation: Vector
    rotation: Quaternion
    source_side: list[str]
    target_side: list[str]


class FrameTree:
    """The histories of all frames. Peers choose the names, so their number is limited.

    Args:
        max_frames: Most frames with a parent; up to twice as many names are kept, temporarily half as many
            again.

    Attributes:
        edges: The history of each frame that has a parent.
        names: All frames, parents included, in order of first mention.
    """

    def __init__(self, max_frames: int = MAX_FRAMES) -> None:
        self.edges: dict[str, History] = {}
        self.names: dict[str, None] = {}
        self._max_frames = max_frames
        self._max_names = 2 * max_frames

    def has_room(self, child: str) -> bool:
        """Whether a pose of this frame may be added."""
        return child in self.edges or len(self.edges) < self._max_frames

    def remember_names(self, child: str, parent: str) -> None:
        """Remember both names, after a pose was added."""
        self.names.update({child: None, parent: None})
        if len(self.names) > self._max_names:  # a sender that keeps inventing parents
            self.drop_former_parents()
            # Leave room, because each clean-up takes time proportional to the number of frames.
            self._max_names = max(2 * self._max_frames, len(self.names) + self._max_frames // 2)

    def drop_former_parents(self) -> None:
        """Forget the names of former parents."""
        parents = (edge.newest.parent for edge in self.edges.values() if len(edge))
        self.names = dict.fromkeys([*self.edges, *parents])

    def lookup(self, target: str, source: str, stamp: int) -> tuple[Pose, int]:
        """The pose of the source in the target, and its time; `stamp` 0 is the newest common time.

        Raises:
            NoPath: There is no transform.
        """
        stamp = stamp or self.latest_common_time(target, source)
        if target == source:  # works for an unknown frame as well
            return IDENTITY, stamp
        return self.find_path(target, source, stamp)[:2], stamp

    def find_path(self, target: str, source: str, stamp: int) -> FramePath:
        """The path between two frames at one time.

        Raises:
            NoPath: There is none.
        """
        edges = self.edges
        up, down = IDENTITY, IDENTITY
        source_side: list[str] = []
        target_side: list[str] = []
        frame, gap = source, None
        while frame != target and frame in edges:
            sample = edges[frame].at(stamp)
            if sample is None:  # perhaps the target is below this frame
                gap = PoseUnknown(frame, edges[frame], stamp)
                break
            up = _step(sample.translation, sample.rotation, up)
            _append(source_side, frame)
            frame = sample.parent
        if frame == target:
            return FramePath(*up, source_side, target_side)
        top, frame = frame, target
        while frame not in (top, source) and frame in edges:
            sample = edges[frame].at(stamp)
            if sample is None:
                raise PoseUnknown(frame, edges[frame], stamp)
            down = _step(sample.translation, sample.rotation, down)
            _append(target_side, frame)
            frame = sample.parent
        there, back = _inverse(down)
        if frame == source != top:
            return FramePath(there, back, source_side, target_side)
        if frame != top:
            raise gap or SeparateTrees(top, frame)
        return FramePath(_sum(rotate(back, up[0]), there), multiply(back, up[1]), source_side, target_side)

    def latest_common_time(self, target: str, source: str) -> int:
        """The newest time (ns) at which the whole path is known; 0 if nothing on it moves.

        Raises:
            SeparateTrees, FrameLoop: There is no path.
        """
        if target == source:
            return self.newest_stamp(source)
        above: list[tuple[int, str]] = []
        while (step := self._newest_parent(above[-1][1] if above else source)) is not None:
            above.append(step)
            if step[1] == target:
                return _earliest(above)
            if len(above) > MAX_DEPTH:
                raise FrameLoop
        parents = [parent for _, parent in above]
        below: list[tuple[int, str]] = []
        frame = target
        while len(below) < MAX_DEPTH:
            step = self._newest_parent(frame)
            if step is None:
                raise SeparateTrees(parents[-1] if parents else source, frame)
            below.append(step)
            frame = step[1]
            if frame in parents:
                return _earliest(below + above[: parents.index(frame) + 1])
            if frame == source:
                return _earliest(below)
        raise FrameLoop

    def newest_stamp(self, frame: str) -> int:
        """The newest stamp of a frame, ns; 0 for one that is static or unknown."""
        edge = self.edges.get(frame)
        return 0 if not edge or edge.static else edge.newest.stamp

    def _newest_parent(self, frame: str) -> tuple[int, str] | None:
        """(newest stamp, newest parent) of a frame; None for a root, or a frame without poses."""
        edge = self.edges.get(frame)
        return (self.newest_stamp(frame), edge.newest.parent) if edge else None


def _earliest(steps: list[tuple[int, str]]) -> int:
    return min((stamp for stamp, _ in steps if stamp), default=0)


def _append(frames: list[str], frame: str) -> None:
    frames.append(frame)
    if len(frames) > MAX_DEPTH:
        raise FrameLoop


def _sum(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _step(translation: Vector, rotation: Quaternion, pose: Pose) -> Pose:
    """Convert a pose in a child to a pose in its parent."""
    return _sum(rotate(rotation, pose[0]), translation), multiply(rotation, pose[1])


def _inverse(pose: Pose) -> Pose:
    (x, y, z), rotation = pose
    back = conjugate(rotation)
    return rotate(back, (-x, -y, -z)), back


# -- the past of one frame ----------------------------------------------------------------------------------
# The poses of one edge of the tree over time, with interpolation: no clock, no I/O.
#
# Source: tf2 cache.cpp, static_cache.cpp (what is kept, and the order of the arithmetic).


OLD = "older than the cache"
REPEATED = "the stamp is known already"


class Sample(NamedTuple):
    """Pose of the child in its parent at one time (`stamp` in ns)."""

    stamp: int
    parent: str
    translation: Vector
    rotation: Quaternion


class History:
    """Poses of one child frame, oldest first; of a static one only the last, which holds at all times.

    Args:
        cache_ns: How much older than the newest a sample may be.
        max_samples: Most samples; None for no limit.
        static: True if the frame does not move.

    Attributes:
        static: True if the frame does not move.
        authority: Node that sent the last one.
    """

    __slots__ = ("_cache_ns", "_max_samples", "_samples", "_stamps", "authority", "static")

    @former_parameters(most="max_samples")
    def __init__(self, cache_ns: int, max_samples: int | None = None, *, static: bool = False) -> None:
        self._cache_ns = cache_ns
        self._max_samples = max_samples
        self._samples: list[Sample] = []
        self._stamps: list[int] = []
        self.static = static
        self.authority = ""

    def add(self, sample: Sample) -> str | None:
        """Add a sample; return why it was refused (`OLD`, or `REPEATED`: the first one stays), or None."""
        if self.static:
            self._samples, self._stamps = [sample], [sample.stamp]
            return None
        if self._stamps and sample.stamp < self._stamps[-1] - self._cache_ns:
            return OLD
        at = bisect_left(self._stamps, sample.stamp)
        if at < len(self._stamps) and self._stamps[at] == sample.stamp:
            return REPEATED
        self._samples.insert(at, sample)
        self._stamps.insert(at, sample.stamp)
        self._forget()
        return None

    def _forget(self) -> None:
        old = bisect_left(self._stamps, self._stamps[-1] - self._cache_ns)
        if self._max_samples is not None:
            old = max(old, len(self._stamps) - self._max_samples)
        if old > 0:
            del self._samples[:old], self._stamps[:old]

    def clear(self) -> None:
        """Forget everything, unless static: that holds whatever the clock does."""
        if not self.static:
            self._samples, self._stamps = [], []

    @property
    def earliest(self) -> int:
        return self._stamps[0]

    @property
    def newest(self) -> Sample:
        return self._samples[-1]

    def __len__(self) -> int:
        return len(self._samples)

    def at(self, stamp: int) -> Sample | None:
        """The pose at a time, 0 for the newest; None outside the known range."""
        stamps = self._stamps
        if not stamps:
            return None
        if self.static or stamp in (0, stamps[-1]):
            return self._samples[-1]
        if stamp == stamps[0]:
            return self._samples[0]
        if not stamps[0] < stamp < stamps[-1]:
            return None
        after = bisect_right(stamps, stamp)
        return _between(self._samples[after - 1], self._samples[after], stamp)


def seconds(ns: int) -> float:
    """Nanoseconds in seconds, computed as roscpp's toSec()."""
    whole, rest = divmod(ns, 1_000_000_000)
    return float(whole) + 1e-9 * rest


def _between(before: Sample, after: Sample, stamp: int) -> Sample:
    if before.parent != after.parent:
        return before  # the parent changed in between; the earlier pose holds until then
    ratio = seconds(stamp - before.stamp) / seconds(after.stamp - before.stamp)
    rest = 1.0 - ratio
    (x0, y0, z0), (x1, y1, z1) = before.translation, after.translation
    moved = (rest * x0 + ratio * x1, rest * y0 + ratio * y1, rest * z0 + ratio * z1)
    return Sample(stamp, before.parent, moved, quaternion.slerp(before.rotation, after.rotation, ratio))
