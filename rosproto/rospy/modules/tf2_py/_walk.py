"""The way between two frames of a tree: by their common root, or straight when one hangs below the other.

Source: tf2 buffer_core.cpp (walkToTopParent, getLatestCommonTime).
"""

from ._errors import ConnectivityException, ExtrapolationException
from ._rotation import add, inverse, multiply, rotate

DEEPEST = 1000


class Loop(Exception):
    """The tree has one; whoever knows all frames says so."""


_NOWHERE = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)


def _step(pose, sum_):
    """One frame further up."""
    translation, rotation = sum_
    return add(rotate(pose.rotation, translation), pose.translation), multiply(pose.rotation, rotation)


def _inverse(sum_):
    translation, rotation = sum_
    back = inverse(rotation)
    return rotate(back, tuple(-part for part in translation)), back


def walk(caches, target, source, stamp):
    """(translation, rotation, frames below the meeting point on the source's side, on the target's).

    Raises:
        Loop, ConnectivityException, ExtrapolationException: There is no way.
    """
    up, down = _NOWHERE, _NOWHERE
    up_frames, down_frames = [], []
    frame = top = source
    gap = None
    while frame in caches:
        pose, why = caches[frame].at(stamp)
        top = frame
        if pose is None:  # perhaps the target hangs below this frame
            gap = why
            break
        if frame == target:
            return (*up, up_frames, down_frames)
        up = _step(pose, up)
        up_frames.append(frame)
        if len(up_frames) > DEEPEST:
            raise Loop
        frame = top = pose.parent
    if frame == target:
        return (*up, up_frames, down_frames)
    frame = target
    while frame != top and frame in caches:
        pose, why = caches[frame].at(stamp)
        if pose is None:
            raise _extrapolation(why, source, target)
        if frame == source:
            return (*_inverse(down), up_frames, down_frames)
        down = _step(pose, down)
        down_frames.append(frame)
        if len(down_frames) > DEEPEST:
            raise Loop
        frame = pose.parent
    if frame == source and frame != top:
        return (*_inverse(down), up_frames, down_frames)
    if frame != top:
        raise not_connected(source, target) if gap is None else _extrapolation(gap, source, target)
    back_translation, back = _inverse(down)
    translation = add(rotate(back, up[0]), back_translation)
    return translation, multiply(back, up[1]), up_frames, down_frames


def latest_common_time(caches, target, source):
    """The newest time for which the whole way is known; 0 when nothing on it moves.

    Raises:
        ConnectivityException, Loop: There is no way.
    """
    up, newest = _newest_up(caches, source, target)
    if up and up[-1][1] == target:
        return newest or 0
    frame, newest, meeting = target, None, None
    parents = [parent for _, parent in up]
    for _ in range(DEEPEST):
        if frame not in caches:
            break
        stamp, parent = caches[frame].newest()
        if parent is None:
            break
        newest = _earlier(newest, stamp)
        if parent in parents:
            meeting = parent
            break
        frame = parent
        if frame == source:
            return newest or 0
    else:
        raise Loop
    if meeting is None:
        raise not_connected(source, target)
    for stamp, parent in up:
        newest = _earlier(newest, stamp)
        if parent == meeting:
            break
    return newest or 0


def _newest_up(caches, frame, target):
    """[(newest time, parent)] from a frame to the root or the target, and the earliest of those times."""
    found, newest = [], None
    while frame in caches:
        stamp, frame = caches[frame].newest()
        if frame is None:
            break
        newest = _earlier(newest, stamp)
        found.append((stamp, frame))
        if frame == target:
            break
        if len(found) > DEEPEST:
            raise Loop
    return found, newest


def _earlier(one, stamp):
    if not stamp:
        return one
    return stamp if one is None else min(one, stamp)


def _extrapolation(why, source, target):
    return ExtrapolationException(
        "%s, when looking up transform from frame [%s] to frame [%s]" % (why, source, target)
    )


def not_connected(source, target):
    """The error for two trees."""
    return ConnectivityException(
        "Could not find a connection between '%s' and '%s' because they are not part of the same tree."
        "Tf has two or more unconnected trees." % (target, source)
    )
