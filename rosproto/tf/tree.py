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
MAX_KEPT = 256  # results, and frames with the poses above them, that are kept for the next lookup

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
        self._climbs: dict[str, _Climb] = {}
        self._found: dict[tuple[str, str, int], tuple[Pose, int]] = {}

    def has_room(self, child: str) -> bool:
        """Whether a pose of this frame may be added."""
        return child in self.edges or len(self.edges) < self._max_frames

    def remember_names(self, child: str, parent: str) -> None:
        """Remember both names; call it whenever a pose was added."""
        self.forget_results()
        self.names.update({child: None, parent: None})
        if len(self.names) > self._max_names:  # a sender that keeps inventing parents
            self.drop_former_parents()
            # Leave room, because each clean-up takes time proportional to the number of frames.
            self._max_names = max(2 * self._max_frames, len(self.names) + self._max_frames // 2)

    def drop_former_parents(self) -> None:
        """Forget the names of former parents."""
        self.forget_results()
        parents = (edge.newest.parent for edge in self.edges.values() if len(edge))
        self.names = dict.fromkeys([*self.edges, *parents])

    def forget_results(self) -> None:
        """Forget what `lookup` has found; call it after every change of the histories."""
        self._found.clear()

    def lookup(self, target: str, source: str, stamp: int) -> tuple[Pose, int]:
        """The pose of the source in the target, and its time; `stamp` 0 is the newest common time.

        Raises:
            NoPath: There is no transform.
        """
        asked = target, source, stamp
        found = self._found.get(asked)
        if found is None:
            stamp = stamp or self.latest_common_time(target, source)
            # A frame is at itself, also an unknown one.
            pose = IDENTITY if target == source else self._path(target, source, stamp)[0]
            if len(self._found) >= MAX_KEPT:
                self.forget_results()
            found = self._found[asked] = pose, stamp
        return found

    def find_path(self, target: str, source: str, stamp: int) -> FramePath:
        """The path between two frames at one time.

        Raises:
            NoPath: There is none.
        """
        pose, source_steps, target_steps = self._path(target, source, stamp)
        return FramePath(
            *pose, self._climb(source).frames(source_steps), self._climb(target).frames(target_steps)
        )

    def _path(self, target: str, source: str, stamp: int) -> tuple[Pose, int, int]:
        """The pose of the source in the target, and the numbers of steps up from both."""
        edges, climb = self.edges, self._climb(source)
        steps, top, gap = climb.up_to((target,), edges, stamp)
        up = climb.poses[steps]
        if top == target:
            return up, steps, 0
        # Where the source's pose is unknown, the target may still be below that frame.
        climb = self._climb(target)
        down_steps, frame, missing = climb.up_to((top, source), edges, stamp)
        if missing is not None:
            raise missing
        there, back = _inverse(climb.poses[down_steps])
        if frame == source != top:
            return (there, back), steps, down_steps
        if frame != top:
            raise gap or SeparateTrees(top, frame)
        return (_sum(rotate(back, up[0]), there), multiply(back, up[1])), steps, down_steps

    def _climb(self, frame: str) -> _Climb:
        climb = self._climbs.get(frame)
        if climb is None:
            if len(self._climbs) >= MAX_KEPT:
                del self._climbs[next(iter(self._climbs))]
            climb = self._climbs[frame] = _Climb(frame)
        return climb

    def latest_common_time(self, target: str, source: str) -> int:
        """The newest time (ns) at which the whole path is known; 0 if nothing on it moves.

        Raises:
            SeparateTrees, FrameLoop: There is no path.
        """
        if target == source:
            return self.newest_stamp(source)
        edges = self.edges
        steps: dict[str, int] = {}  # to each frame above the source
        above: list[int] = []
        frame = source
        while (edge := edges.get(frame)) is not None and (newest := edge.last) is not None:
            above.append(0 if edge.static else newest.stamp)
            frame = newest.parent
            steps.setdefault(frame, len(above))
            if frame == target:
                return _earliest(above)
            if len(above) > MAX_DEPTH:
                raise FrameLoop
        root, frame = frame, target
        below: list[int] = []
        while len(below) < MAX_DEPTH:
            if (edge := edges.get(frame)) is None or (newest := edge.last) is None:
                raise SeparateTrees(root, frame)
            below.append(0 if edge.static else newest.stamp)
            frame = newest.parent
            if frame in steps:
                return _earliest(below + above[: steps[frame]])
            if frame == source:
                return _earliest(below)
        raise FrameLoop

    def newest_stamp(self, frame: str) -> int:
        """The newest stamp of a frame, ns; 0 for one that is static or unknown."""
        edge = self.edges.get(frame)
        return 0 if not edge or edge.static else edge.newest.stamp


def _earliest(stamps: list[int]) -> int:
    return min(filter(None, stamps), default=0)


class _Climb:
    """The poses of a frame in those above it, as the last lookup found them.

    The next one computes anew from the first sample that is another object. Samples are values and name the
    parent, so that no change of the tree makes a kept pose wrong. The order of the arithmetic stays tf2's.

    Attributes:
        samples: The pose of each frame in the next one.
        poses: The pose of the first frame in itself, and after each sample.
    """

    __slots__ = ("_frame", "poses", "samples")

    def __init__(self, frame: str) -> None:
        self._frame = frame
        self.samples: list[Sample] = []
        self.poses: list[Pose] = [IDENTITY]

    def frames(self, steps: int) -> list[str]:
        """The frames of the first steps, without the last parent."""
        return [self._frame, *(sample.parent for sample in self.samples)][:steps]

    def up_to(
        self, ends: tuple[str, ...], edges: dict[str, History], stamp: int
    ) -> tuple[int, str, PoseUnknown | None]:
        """Go up to one of `ends`, a root or a gap: the number of steps, the frame there, and the gap."""
        samples, poses = self.samples, self.poses
        steps, frame = 0, self._frame
        while frame not in ends and (edge := edges.get(frame)) is not None:
            sample = edge.at(stamp)
            if sample is None:
                return steps, frame, PoseUnknown(frame, edge, stamp)
            if steps == len(samples) or samples[steps] is not sample:
                del samples[steps:], poses[steps + 1 :]
                samples.append(sample)
                poses.append(_step(sample.translation, sample.rotation, poses[steps]))
            steps += 1
            if steps > MAX_DEPTH:
                raise FrameLoop
            frame = sample.parent
        return steps, frame, None


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
        last: The newest sample; None if there is none.
    """

    __slots__ = (
        "_between", "_cache_ns", "_max_samples", "_samples", "_stamps", "authority", "last", "static",
    )  # fmt: skip

    @former_parameters(most="max_samples")
    def __init__(self, cache_ns: int, max_samples: int | None = None, *, static: bool = False) -> None:
        self._cache_ns = cache_ns
        self._max_samples = max_samples
        self._samples: list[Sample] = []
        self._stamps: list[int] = []
        self._between: Sample | None = None  # the last that was computed
        self.last: Sample | None = None
        self.static = static
        self.authority = ""

    def add(self, sample: Sample) -> str | None:
        """Add a sample; return why it was refused (`OLD`, or `REPEATED`: the first one stays), or None."""
        if self.static:
            self._samples, self._stamps, self.last = [sample], [sample.stamp], sample
            return None
        if self._stamps and sample.stamp < self._stamps[-1] - self._cache_ns:
            return OLD
        at = bisect_left(self._stamps, sample.stamp)
        if at < len(self._stamps) and self._stamps[at] == sample.stamp:
            return REPEATED
        if at < len(self._stamps):
            self._between = None
        self._samples.insert(at, sample)
        self._stamps.insert(at, sample.stamp)
        self.last = self._samples[-1]
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
            self._samples, self._stamps, self._between, self.last = [], [], None, None

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
        if self.static or stamp == 0 or stamp == stamps[-1]:
            return self.last
        if stamp == stamps[0]:
            return self._samples[0]
        if not stamps[0] < stamp < stamps[-1]:
            return None
        known = self._between
        if known is None or known.stamp != stamp:
            after = bisect_right(stamps, stamp)
            known = self._between = _between(self._samples[after - 1], self._samples[after], stamp)
        return known


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
