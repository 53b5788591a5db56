"""tf.Transformer: tf2's buffer with the older interface; poses are [x, y, z], [x, y, z, w]."""

import tf2_ros

_ALONE = "cannot wait for transform without a dedicated thread that listens to incoming TF messages"


def strip_leading_slash(name):
    """The tf2 name: without the leading slash."""
    return name[1:] if name.startswith("/") else name


def _between(target_frame, target_time, source_frame, source_time, fixed_frame):
    """Arguments of a lookup between two times, with tf2 frame names."""
    target, source, fixed = map(strip_leading_slash, (target_frame, source_frame, fixed_frame))
    return target, target_time, source, source_time, fixed


def _parts(message):
    t, r = message.transform.translation, message.transform.rotation
    return [t.x, t.y, t.z], [r.x, r.y, r.z, r.w]


class Transformer:
    """A buffer whose lookups return lists."""

    def __init__(self, interpolate=True, cache_time=None):
        self._buffer = tf2_ros.Buffer(cache_time, debug=False)
        self._using_dedicated_thread = False

    def allFramesAsDot(self, current_time=None):
        """Frames as a Graphviz graph, with ages relative to `current_time` if given."""
        return self._buffer.all_frames_as_dot(*([current_time] if current_time else []))

    def allFramesAsString(self):
        """All frames with their parents."""
        return self._buffer.all_frames_as_string()

    def setTransform(self, transform, authority="default_authority"):
        """Store a TransformStamped."""
        self._buffer.set_transform(transform, authority)

    def canTransform(self, target_frame, source_frame, time):
        """True if `lookupTransform` would succeed."""
        return self._buffer.can_transform(
            strip_leading_slash(target_frame), strip_leading_slash(source_frame), time
        )

    def canTransformFull(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """As `canTransform`, between two times."""
        return self._buffer.can_transform_full(
            *_between(target_frame, target_time, source_frame, source_time, fixed_frame),
        )

    def waitForTransform(self, target_frame, source_frame, time, timeout, polling_sleep_duration=None):
        """Wait until the transform is available.

        Raises:
            tf.Exception: The transform is not available within `timeout`.
        """
        self._require_thread()
        done, why = self._buffer.can_transform(
            strip_leading_slash(target_frame),
            strip_leading_slash(source_frame),
            time,
            timeout,
            return_debug_tuple=True,
        )
        self._require(done, why, source_frame, target_frame)

    def waitForTransformFull(
        self,
        target_frame,
        target_time,
        source_frame,
        source_time,
        fixed_frame,
        timeout,
        polling_sleep_duration=None,
    ):
        """As `waitForTransform`, between two times."""
        self._require_thread()
        done, why = self._buffer.can_transform_full(
            *_between(target_frame, target_time, source_frame, source_time, fixed_frame),
            timeout,
            return_debug_tuple=True,
        )
        self._require(done, why, source_frame, target_frame)

    def _require_thread(self):
        if not self._using_dedicated_thread:
            raise tf2_ros.TransformException(_ALONE)

    @staticmethod
    def _require(done, why, source_frame, target_frame):
        if not done:
            raise tf2_ros.TransformException(
                why or 'no such transformation: "%s" -> "%s"' % (source_frame, target_frame)
            )

    def chain(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """Frames between source and target."""
        return self._buffer.chain(target_frame, target_time, source_frame, source_time, fixed_frame)

    def lookupTransform(self, target_frame, source_frame, time):
        """Pose of the source frame in the target frame: [x, y, z] in m, [x, y, z, w]."""
        return _parts(
            self._buffer.lookup_transform(
                strip_leading_slash(target_frame), strip_leading_slash(source_frame), time
            )
        )

    def lookupTransformFull(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """As `lookupTransform`, between two times."""
        return _parts(
            self._buffer.lookup_transform_full(
                *_between(target_frame, target_time, source_frame, source_time, fixed_frame),
            )
        )

    def lookupTwist(self, tracking_frame, observation_frame, time, averaging_interval):
        """Mean velocity of a frame relative to another: (vx, vy, vz) in m/s, (wx, wy, wz) in rad/s."""
        return self.lookupTwistFull(
            tracking_frame,
            observation_frame,
            observation_frame,
            (0, 0, 0),
            tracking_frame,
            time,
            averaging_interval,
        )

    def lookupTwistFull(
        self,
        tracking_frame,
        observation_frame,
        reference_frame,
        ref_point,
        reference_point_frame,
        time,
        averaging_interval,
    ):
        """As `lookupTwist`, expressed in a third frame."""
        from .twist import between

        return between(
            self,
            tracking_frame,
            observation_frame,
            reference_frame,
            reference_point_frame,
            time,
            averaging_interval,
        )

    def getLatestCommonTime(self, source_frame, dest_frame):
        """The newest time for which the transform is available."""
        return self._buffer.get_latest_common_time(
            strip_leading_slash(source_frame), strip_leading_slash(dest_frame)
        )

    def frameExists(self, frame_id):
        """True if the frame has a known parent; False for the root."""
        return frame_id in self.getFrameStrings()

    def getFrameStrings(self):
        """Names of all frames with a known parent."""
        return self._buffer.child_frames()

    def clear(self):
        """Remove all transforms except static ones."""
        self._buffer.clear()

    def setUsingDedicatedThread(self, value):
        """Set whether another thread fills this buffer; required for waiting."""
        self._using_dedicated_thread = value

    def getTFPrefix(self):
        """Always empty: tf2 has no prefixes."""
        return ""
