"""tf2_py: tf2's BufferCore, the transforms of all frames with lookups that do not wait, and its exceptions.

The engine is `rosproto.tf`; its results equal tf2's to the last digit, since programs print them.

Source: tf2 buffer_core.cpp and tf2_py.cpp (names, error texts, warnings on stderr). Tracebacks show the
exceptions under the name of its C module, tf2; the graph of all frames is that of view_frames.
"""

import math
import sys
import threading

import genpy
from geometry_msgs.msg import TransformStamped
from rospy.rostime import Time

from rosproto.quaternion import from_matrix, to_matrix
from rosproto.tf.tree import (
    MAX_FRAMES,
    MAX_NAME_CHARACTERS,
    MAX_SAMPLES,
    OLD,
    REPEATED,
    FrameLoop,
    FrameTree,
    History,
    NoPath,
    PoseUnknown,
    Sample,
    seconds,
)

__all__ = [
    "BufferCore",
    "ConnectivityException",
    "ExtrapolationException",
    "InvalidArgumentException",
    "LookupException",
    "TimeoutException",
    "TransformException",
]

EDGE = (
    '"%(parent)s" -> "%(name)s"[label="Broadcaster: %(broadcaster)s\\nAverage rate: %(rate).3f Hz\\n'
    "Most recent transform: %(most_recent_transform).3f %(age)s\\n"
    'Buffer length: %(buffer_length).3f sec\\n"];\n'
)
ROOT = (
    'edge [style=invis];\n subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";\n'
    '"Recorded at time: %.3f"[ shape=plaintext ] ;\n }->"%s";\n'
)


def _described(edge):
    """What the listings say of a transform, times in seconds; all times of a static one are 0."""
    newest, oldest = (0, 0) if edge.static else (edge.newest.stamp, edge.earliest)
    length = (newest - oldest) / 1e9
    return {
        "parent": edge.newest.parent,
        "broadcaster": edge.authority,
        "rate": len(edge) / max(length, 0.0001),
        "most_recent_transform": newest / 1e9,
        "oldest_transform": oldest / 1e9,
        "buffer_length": length,
    }


class TransformException(Exception):
    """A transform is not available."""


class ConnectivityException(TransformException):
    """The frames are known but not connected."""


class LookupException(TransformException):
    """A frame is unknown."""


class ExtrapolationException(TransformException):
    """The transform is known, but not for the requested time."""


class InvalidArgumentException(TransformException):
    """An argument is invalid."""


class TimeoutException(TransformException):
    """The timeout expired."""


for _error in (TransformException, *TransformException.__subclasses__()):
    _error.__module__ = "tf2"


def error_of(no_path, target, source):
    """The exception for a `PoseUnknown` or `SeparateTrees` of the tree."""
    if isinstance(no_path, PoseUnknown):
        return ExtrapolationException(
            "%s, when looking up transform from frame [%s] to frame [%s]" % (_why(no_path), source, target)
        )
    return ConnectivityException(
        "Could not find a connection between '%s' and '%s' because they are not part of the same tree."
        "Tf has two or more unconnected trees." % (target, source)
    )


def _why(gap):
    stamp, known = gap.stamp, gap.history
    if not known:  # cleared: tf2 gives no reason
        return ""
    if len(known) == 1:
        return (
            "Lookup would require extrapolation at time %.09f, but only time %.09f is in the buffer"
            % (seconds(stamp), seconds(known.earliest))
        )[:115]  # size of tf2's text buffer
    if stamp > known.newest.stamp:
        return _beyond(stamp, known.newest.stamp, "future", "latest")
    return _beyond(stamp, known.earliest, "past", "earliest")


def _beyond(asked, known, where, which):
    return (
        "Lookup would require extrapolation %.09fs into the %s.  Requested time %.09f but the %s data is at"
        " time %.09f" % (seconds(abs(asked - known)), where, seconds(asked), which, seconds(known))
    )


_NOT_TAKEN = {
    OLD: "TF_OLD_DATA ignoring data from the past"
    " (Possible reasons are listed at http://wiki.ros.org/tf/Errors%%20explained)",
    REPEATED: "TF_REPEATED_DATA ignoring data with redundant timestamp",
}
UNIT_TOLERANCE = 10e-3  # of the squared norm of a quaternion


def nanoseconds(time):
    """Time in nanoseconds, rounded through a double of seconds as in tf2."""
    try:
        seconds = time.to_sec()
    except AttributeError:
        raise TypeError("time must have a to_sec method, e.g. rospy.Time or rospy.Duration") from None
    whole = math.floor(seconds)
    return whole * 1000000000 + math.floor((seconds - whole) * 1e9 + 0.5)


def _say(kind, text, line):
    """Write a message in the format of console_bridge, tf2's logger."""
    sys.stderr.write("%-9s%s\n         at line %d in ./tf2/src/buffer_core.cpp\n" % (kind, text, line))


class BufferCore:
    """Poses of frames over the last `cache_time`; all methods are thread-safe."""

    def __init__(self, cache_time=None):
        self._duration = nanoseconds(genpy.Duration(10)) if cache_time is None else nanoseconds(cache_time)
        self._tree = FrameTree()
        self._lock = threading.RLock()
        self._warned = False

    # -- filling --------------------------------------------------------------------------------------------

    def set_transform(self, transform, authority):
        """Store a TransformStamped."""
        self._set(transform, authority, False)

    def set_transform_static(self, transform, authority):
        """Store a static TransformStamped."""
        self._set(transform, authority, True)

    def _set(self, transform, authority, static):
        stamp = nanoseconds(transform.header.stamp)
        child, parent = _stripped(transform.child_frame_id), _stripped(transform.header.frame_id)
        t, r = transform.transform.translation, transform.transform.rotation
        translation, rotation = tuple(map(float, (t.x, t.y, t.z))), tuple(map(float, (r.x, r.y, r.z, r.w)))
        found = _problems(child, parent, translation, rotation, authority)
        problems = [(line, text) for is_so, line, text in found if is_so]
        for line, text in problems:
            _say("Error:", text, line)
        if problems:
            return
        with self._lock:
            if max(len(child), len(parent)) > MAX_NAME_CHARACTERS or not self._tree.has_room(child):
                self._leave_out(child, authority)
                return
            edge = self._tree.edges.get(child)
            if edge is None:  # static if the first pose is, as in tf2
                edge = self._tree.edges[child] = History(self._duration, MAX_SAMPLES, static=static)
            self._tree.remember_names(child, parent)
            why = edge.add(Sample(stamp, parent, translation, rotation))
            if why is None:
                edge.authority = authority
                return
        where = " for frame %s (parent %s) at time %f according to authority %s"
        _say("Warning:", (_NOT_TAKEN[why] + where) % (child, parent, seconds(stamp), authority), 278)

    def _leave_out(self, child, authority):
        """Report a frame beyond the bounds (tf2 has none), only once: invented names are unlimited."""
        if not self._warned:
            self._warned = True
            text = 'Ignoring transform for child_frame_id "%s" from authority "%s"'
            text += ": %d frames of %d characters at most"
            _say("Error:", text % (child[:100], authority, MAX_FRAMES, MAX_NAME_CHARACTERS), 278)

    def clear(self):
        """Remove all transforms except static ones."""
        with self._lock:
            for edge in self._tree.edges.values():
                edge.clear()
            self._tree.forget_results()

    # -- looking up -----------------------------------------------------------------------------------------

    def lookup_transform_core(self, target_frame, source_frame, time):
        """Pose of the source frame in the target frame, a TransformStamped.

        Raises:
            LookupException, ConnectivityException, ExtrapolationException, InvalidArgumentException
        """
        stamp = nanoseconds(time)
        with self._lock:
            return _message(*self._lookup(target_frame, source_frame, stamp), target_frame, source_frame)

    def lookup_transform_full_core(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """As `lookup_transform_core`, between two times through a frame that does not move."""
        then, now = nanoseconds(source_time), nanoseconds(target_time)
        with self._lock:
            for which, frame in (("target", target_frame), ("source", source_frame), ("fixed", fixed_frame)):
                self._validate("lookupTransform argument %s_frame" % which, frame)
            there, _ = self._lookup(fixed_frame, source_frame, then)
            back, stamp = self._lookup(target_frame, fixed_frame, now)
        return _message(combined(back, there), stamp, target_frame, source_frame)

    def can_transform_core(self, target_frame, source_frame, time):
        """Return (1, "") if the transform is available, else (0, reason)."""
        stamp = nanoseconds(time)
        if target_frame == source_frame:
            return 1, ""
        if self._is_odd("target", target_frame) or self._is_odd("source", source_frame):
            return 0, ""
        with self._lock:
            missing = self._missing(target=target_frame, source=source_frame)
            return (0, missing) if missing else self._can(target_frame, source_frame, stamp)

    def can_transform_full_core(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """As `can_transform_core`, between two times."""
        then, now = nanoseconds(source_time), nanoseconds(target_time)
        frames = {"target": target_frame, "source": source_frame, "fixed": fixed_frame}
        if any(self._is_odd(which, frame) for which, frame in frames.items()):
            return 0, ""
        with self._lock:
            missing = self._missing(target=target_frame, source=source_frame)
            if source_frame not in self._tree.names:  # tf2's text and condition
                missing += " fixed_frame: %sdoes not exist." % fixed_frame
            if any(frame not in self._tree.names for frame in frames.values()):
                return 0, missing
            done = self._can(target_frame, fixed_frame, now)
            return self._can(fixed_frame, source_frame, then) if done[0] else done

    def _can(self, target, source, stamp):
        try:
            self._lookup(target, source, stamp)
        except TransformException as error:
            return 0, str(error)
        return 1, ""

    def _lookup(self, target, source, stamp):
        """Return ((translation, rotation), nanoseconds)."""
        if target != source:
            self._validate("lookupTransform argument target_frame", target)
            self._validate("lookupTransform argument source_frame", source)
        return self._in_tree(self._tree.lookup, target, source, stamp)

    def _in_tree(self, find, target, source, *stamp):
        try:
            return find(target, source, *stamp)
        except FrameLoop:
            frames = self.all_frames_as_string()
            raise LookupException(
                "The tf tree is invalid because it contains a loop.\n%s\n" % frames
            ) from None
        except NoPath as no_path:
            raise error_of(no_path, target, source) from None

    def get_latest_common_time(self, target_frame, source_frame):
        """The newest time for which the transform is available."""
        with self._lock:
            for frame in (target_frame, source_frame):
                self._validate("get_latest_common_time", frame)
            try:
                stamp = self._in_tree(self._tree.latest_common_time, target_frame, source_frame)
            except TransformException as error:  # tf2 raises the base class here
                raise TransformException(str(error)) from None
        return _time(stamp)

    def _validate(self, argument, frame):
        text = _oddity(argument, frame)
        if text:
            raise InvalidArgumentException(text)
        if frame not in self._tree.names:
            raise LookupException('"%s" passed to %s does not exist. ' % (frame, argument))

    @staticmethod
    def _is_odd(which, frame):
        text = _oddity("canTransform argument %s_frame" % which, frame)
        if text:
            _say("Warning:", text, 134 if frame else 126)
        return bool(text)

    def _missing(self, **frames):
        return " ".join(
            "canTransform: %s_frame %s does not exist." % (which, frame)
            for which, frame in frames.items()
            if frame not in self._tree.names
        )

    # -- listing --------------------------------------------------------------------------------------------

    def _in_order(self):
        edges = self._tree.edges
        return [(name, edges[name]) for name in self._tree.names if name in edges]

    def all_frames_as_yaml(self):
        """All frames with parents and times, as YAML."""
        with self._lock:
            if not self._tree.names:
                return "{}"
            text = ""
            for name, edge in self._in_order():
                if edge:
                    text += "%s: \n" % name
                    for key, value in _described(edge).items():
                        text += "  %s: %s\n" % (key, ("%.3f" if isinstance(value, float) else "'%s'") % value)
            return text

    def all_frames_as_string(self):
        """All frames with parents, one per line."""
        with self._lock:
            return "".join(
                "Frame %s exists with parent %s.\n" % (name, edge.newest.parent if edge else "NO_PARENT")
                for name, edge in self._in_order()
            )

    def all_frames_as_dot(self, current_time=None):
        """All frames as a Graphviz graph."""
        if current_time is not None and not hasattr(current_time, "to_sec"):
            raise TypeError("time must have a to_sec method, e.g. rospy.Time or rospy.Duration")
        now = current_time.to_sec() if current_time is not None else 0.0
        with self._lock:
            names, edges = list(self._tree.names), self._tree.edges
            if not names:
                return 'digraph G {\n"no tf data recieved"}'  # tf2's spelling
            lines = ["digraph G {\n"]
            for name in names:
                if edges.get(name):
                    about = _described(edges[name])
                    newest = about["most_recent_transform"]
                    about["age"] = "( %.3f sec old)" % (now - newest) if now > 0 else ""
                    lines.append(EDGE % {**about, "name": name})
            if now > 0:
                lines += [ROOT % (now, name) for name in names if not edges.get(name)]
        return "".join([*lines, "}"])

    def child_frames(self):
        """Names of all frames with a known parent."""
        with self._lock:
            return [name for name, edge in self._in_order() if edge]

    def frame_exists(self, frame):
        """True for a known frame, including the root."""
        return frame in self._tree.names

    def frame_names(self):
        """Names of all frames, including the root."""
        return list(self._tree.names)

    def chain(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """Frames on the path from source to target."""
        with self._lock:
            there = self._walk(fixed_frame, source_frame, nanoseconds(source_time))
            back = self._walk(target_frame, fixed_frame, nanoseconds(target_time))
        frames = [*there[0], fixed_frame, *there[1], *back[0], *back[1], target_frame]
        return list(dict.fromkeys(frames))

    def _walk(self, target, source, stamp):
        way = self._in_tree(self._tree.find_path, target, source, stamp)
        return way.source_side, way.target_side[::-1]

    # tf2's names for them
    _allFramesAsDot, _chain = all_frames_as_dot, chain
    _frameExists, _getFrameStrings = frame_exists, frame_names


def _problems(child, parent, translation, rotation, authority):
    """Checks of a transform: (True if it fails, the line in tf2 0.7.6 that its logger adds, text)."""
    x, y, z, w = rotation
    yield (
        child == parent,
        221,
        'TF_SELF_TRANSFORM: Ignoring transform from authority "%s" with frame_id and child_frame_id '
        ' "%s" because they are the same' % (authority, child),
    )
    yield (
        not child,
        227,
        'TF_NO_CHILD_FRAME_ID: Ignoring transform from authority "%s" because child_frame_id not set '
        % authority,
    )
    yield (
        not parent,
        233,
        'TF_NO_FRAME_ID: Ignoring transform with child_frame_id "%s"  from authority "%s" because frame_id'
        " not set" % (child, authority),
    )
    yield (
        any(map(math.isnan, (*translation, *rotation))),
        240,
        'TF_NAN_INPUT: Ignoring transform for child_frame_id "%s" from authority "%s" because of a nan value'
        " in the transform (%f %f %f) (%f %f %f %f)" % (child, authority, *translation, *rotation),
    )
    yield (
        not abs(w * w + x * x + y * y + z * z - 1.0) < UNIT_TOLERANCE,
        255,
        'TF_DENORMALIZED_QUATERNION: Ignoring transform for child_frame_id "%s" from authority "%s" because'
        " of an invalid quaternion in the transform (%f %f %f %f)" % (child, authority, *rotation),
    )


def _oddity(argument, frame):
    """What is wrong with a frame's name; "" for nothing."""
    if not frame:
        return "Invalid argument passed to %s in tf2 frame_ids cannot be empty" % argument
    if frame.startswith("/"):
        text = "Invalid argument \"%s\" passed to %s in tf2 frame_ids cannot start with a '/' like: "
        return text % (frame, argument)
    return ""


def _stripped(name):
    return name[1:] if name.startswith("/") else name


def _time(stamp):
    return Time(*divmod(stamp, 1000000000))


def _message(pose, stamp, target, source):
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = target, source
    message.header.stamp = _time(stamp)
    t, r = message.transform.translation, message.transform.rotation
    (t.x, t.y, t.z), (r.x, r.y, r.z, r.w) = pose
    return message


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def combined(second, first):
    """(translation, rotation) of `first`, then `second`, computed by matrices as in tf2.

    Source: tf2/LinearMath/Transform.h (order of each sum).
    """
    (translation, rotation), (there, turned) = second, first
    a, b = to_matrix(rotation), to_matrix(turned)
    product = [[_dot(row, column) for column in zip(*b)] for row in a]
    moved = tuple(_dot(row, there) + offset for row, offset in zip(a, translation))
    return moved, from_matrix(product)
