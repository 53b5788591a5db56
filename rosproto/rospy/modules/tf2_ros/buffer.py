"""tf2_ros.Buffer over rosproto's transform buffer, with tf2's errors and words."""

import rospy
from geometry_msgs.msg import TransformStamped

from rosproto import tf as _tf

ZERO = rospy.Duration(0.0)


class TransformException(Exception):
    """A transform cannot be had."""


class ConnectivityException(TransformException):
    """Both frames are known, but not connected."""


class LookupException(TransformException):
    """A frame is unknown."""


class ExtrapolationException(TransformException):
    """It is known, but not for that time."""


class InvalidArgumentException(TransformException):
    """An argument makes no sense."""


class TimeoutException(TransformException):
    """It took too long."""


class TypeException(Exception):
    """A type cannot be transformed."""


class NotImplementedException(Exception):
    """It is not there."""


class TransformRegistration:
    """Functions that transform stamped data, by type: `function(data, transform) -> data`."""

    _functions = {}

    @classmethod
    def add(cls, key, callback):
        """Register one."""
        cls._functions[key] = callback

    @classmethod
    def get(cls, key):
        """The function of a type.

        Raises:
            TypeException: There is none.
        """
        if key not in cls._functions:
            from . import geometry

            geometry.register(cls)
        if key not in cls._functions:
            raise TypeException("Type %s is not loaded or supported" % str(key))
        return cls._functions[key]


def _seconds(duration):
    return duration.to_sec() if hasattr(duration, "to_sec") else float(duration)


def _translated(error, moment):
    """tf2's exception for one of ours."""
    if isinstance(error, _tf.UnknownFrame):
        which = "target_frame" if error.frame == error.target else "source_frame"
        return LookupException(
            '"%s" passed to lookupTransform argument %s does not exist. ' % (error.frame, which)
        )
    if isinstance(error, _tf.NotConnected):
        return ConnectivityException(
            "Could not find a connection between '%s' and '%s' because they are not part of the same tree."
            "Tf has two or more unconnected trees." % (error.target, error.source)
        )
    if not isinstance(error, _tf.ExtrapolationError):
        return TransformException(str(error))
    frames = "when looking up transform from frame [%s] to frame [%s]" % (error.source, error.target)
    if error.earliest == error.latest:
        return ExtrapolationException(
            "Lookup would require extrapolation at time %.9f, but only time %.9f is in the buffer, %s"
            % (error.requested, error.latest, frames)
        )
    late = error.requested > error.latest
    return ExtrapolationException(
        "Lookup would require extrapolation %.9fs into the %s.  Requested time %.9f but the %s data is at"
        " time %.9f, %s"
        % (
            abs(error.requested - (error.latest if late else error.earliest)),
            "future" if late else "past",
            error.requested,
            "latest" if late else "earliest",
            error.latest if late else error.earliest,
            frames,
        )
    )


def to_message(transform, cls=TransformStamped):
    """A geometry_msgs/TransformStamped as this program's messages are."""
    message = cls()
    message.header.frame_id, message.child_frame_id = transform.target, transform.source
    message.header.stamp.secs, message.header.stamp.nsecs = divmod(transform.stamp_ns, 1000000000)
    t, r = message.transform.translation, message.transform.rotation
    t.x, t.y, t.z = transform.translation
    r.x, r.y, r.z, r.w = transform.rotation
    return message


class BufferCore:
    """Transforms of the last seconds, and lookups without waiting."""

    def __init__(self, cache_time=None):
        self._buffer = _tf.TransformBuffer(10.0 if cache_time is None else _seconds(cache_time))

    def set_transform(self, transform, authority):
        """Take a TransformStamped."""
        self._set(transform, authority, False)

    def set_transform_static(self, transform, authority):
        """Take one that holds at all times."""
        self._set(transform, authority, True)

    def _set(self, transform, authority, static):
        try:
            self._buffer.set_transform(transform, authority=authority, static=static)
        except ValueError as error:
            rospy.logerr(
                'TF_INVALID: Ignoring transform for child_frame_id "%s" from authority "%s": %s',
                transform.child_frame_id,
                authority,
                error,
            )

    def _lookup(self, function, moment, *frames):
        for frame in frames:
            self._check(frame)
        try:
            return to_message(function())
        except _tf.TransformError as error:
            raise _translated(error, moment) from None
        except ValueError as error:
            raise InvalidArgumentException(str(error)) from None

    @staticmethod
    def _check(frame):
        if not frame:
            raise InvalidArgumentException(
                "Invalid argument passed to lookupTransform argument target_frame in tf2"
                " frame_ids cannot be empty"
            )
        if frame.startswith("/"):
            raise InvalidArgumentException(
                'Invalid argument "%s" passed to lookupTransform argument target_frame in tf2'
                " frame_ids cannot start with a '/' like: " % frame
            )

    def lookup_transform_core(self, target_frame, source_frame, time):
        """The transform from source to target."""
        return self._lookup(
            lambda: self._buffer.lookup(target_frame, source_frame, time), time, target_frame, source_frame
        )

    def lookup_transform_full_core(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """The same between two times, by way of a frame that did not move."""
        return self._lookup(
            lambda: self._buffer.lookup_full(
                target_frame, target_time, source_frame, source_time, fixed_frame
            ),
            source_time,
            target_frame,
            source_frame,
            fixed_frame,
        )

    def can_transform_core(self, target_frame, source_frame, time):
        """(1, "") when there is one, else (0, why); numbers, as tf2's C code gives them."""
        try:
            self.lookup_transform_core(target_frame, source_frame, time)
        except TransformException as error:
            return 0, str(error)
        return 1, ""

    def clear(self):
        """Forget what moves."""
        self._buffer.clear()

    def all_frames_as_yaml(self):
        """Every frame, its parent and its times, as YAML."""
        lines = []
        for child, facts in self._buffer.frames().items():
            span = facts["latest"] - facts["earliest"]
            rate = facts["samples"] / span if span > 0 else 10000.0
            lines.append(
                "%s: \n  parent: '%s'\n  broadcaster: '%s'\n  rate: %.3f\n  most_recent_transform: %.3f\n"
                "  oldest_transform: %.3f\n  buffer_length: %.3f\n"
                % (
                    child,
                    facts["parent"],
                    facts["authority"],
                    rate,
                    facts["latest"],
                    facts["earliest"],
                    span,
                )
            )
        return "".join(lines) or "{}"

    def all_frames_as_string(self):
        """Every frame and its parent, a line each."""
        return "".join(
            "Frame %s exists with parent %s.\n" % (child, facts["parent"])
            for child, facts in self._buffer.frames().items()
        )

    def _frameExists(self, frame):
        return frame.lstrip("/") in self._names()

    def _getFrameStrings(self):
        return sorted(self._names())

    def _names(self):
        frames = self._buffer.frames()
        return {*frames, *(facts["parent"] for facts in frames.values())}

    def get_latest_common_time(self, target_frame, source_frame):
        """The newest time for which the transform is known."""
        stamp = self.lookup_transform_core(target_frame, source_frame, rospy.Time(0)).header.stamp
        return rospy.Time(stamp.secs, stamp.nsecs)


class BufferInterface:
    """`transform`, over `lookup_transform`."""

    def __init__(self):
        self.registration = TransformRegistration

    def transform(self, object_stamped, target_frame, timeout=ZERO, new_type=None):
        """Stamped data in another frame."""
        function = self.registration.get(type(object_stamped))
        header = object_stamped.header
        return function(
            object_stamped, self.lookup_transform(target_frame, header.frame_id, header.stamp, timeout)
        )

    def transform_full(
        self,
        object_stamped,
        target_frame,
        target_time,
        fixed_frame,
        timeout=ZERO,
        new_type=None,
    ):
        """The same between two times."""
        function = self.registration.get(type(object_stamped))
        header = object_stamped.header
        return function(
            object_stamped,
            self.lookup_transform_full(
                target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout
            ),
        )


class Buffer(BufferCore, BufferInterface):
    """A buffer that can wait."""

    def __init__(self, cache_time=None, debug=True):
        BufferCore.__init__(self, cache_time)
        BufferInterface.__init__(self)

    def lookup_transform(self, target_frame, source_frame, time, timeout=ZERO):
        """The transform from source to target, waiting for it at most `timeout`.

        Raises:
            LookupException, ConnectivityException, ExtrapolationException: It cannot be had.
        """
        self.can_transform(target_frame, source_frame, time, timeout)
        return self.lookup_transform_core(target_frame, source_frame, time)

    def lookup_transform_full(
        self,
        target_frame,
        target_time,
        source_frame,
        source_time,
        fixed_frame,
        timeout=ZERO,
    ):
        """The same between two times."""
        self.can_transform_full(target_frame, target_time, source_frame, source_time, fixed_frame, timeout)
        return self.lookup_transform_full_core(
            target_frame, target_time, source_frame, source_time, fixed_frame
        )

    def can_transform(self, target_frame, source_frame, time, timeout=ZERO, return_debug_tuple=False):
        """True when there is one, within `timeout`."""
        result = self._wait(lambda: self.can_transform_core(target_frame, source_frame, time), timeout)
        return result if return_debug_tuple else result[0]

    def can_transform_full(
        self,
        target_frame,
        target_time,
        source_frame,
        source_time,
        fixed_frame,
        timeout=ZERO,
        return_debug_tuple=False,
    ):
        """The same between two times."""

        def ask():
            try:
                self.lookup_transform_full_core(
                    target_frame, target_time, source_frame, source_time, fixed_frame
                )
            except TransformException as error:
                return 0, str(error)
            return 1, ""

        result = self._wait(ask, timeout)
        return result if return_debug_tuple else result[0]

    @staticmethod
    def _wait(ask, timeout):
        result = ask()
        seconds = _seconds(timeout)
        if result[0] or seconds <= 0:
            return result
        end = rospy.Time.now() + rospy.Duration(seconds)
        pause = rospy.Duration(0.02)
        while rospy.Time.now() < end and not result[0] and not rospy.is_shutdown():
            rospy.sleep(pause)
            result = ask()
        return result
