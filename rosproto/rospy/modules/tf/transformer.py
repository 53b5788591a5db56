"""tf.Transformer: tf2's buffer with the older interface; poses are [x, y, z], [x, y, z, w]."""

import tf2_ros

_ALONE = "cannot wait for transform without a dedicated thread that listens to incoming TF messages"


def strip_leading_slash(name):
    """The name as tf2 knows it: without the leading slash."""
    return name[1:] if name.startswith("/") else name


def _between(target_frame, target_time, source_frame, source_time, fixed_frame):
    """Arguments of a lookup between two times, with the frames as tf2 knows them."""
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
        """The frames as a graph for graphviz; with their ages when the time is given."""
        return self._buffer.all_frames_as_dot(*([current_time] if current_time else []))

    def allFramesAsString(self):
        """Every frame and its parent."""
        return self._buffer.all_frames_as_string()

    def setTransform(self, transform, authority="default_authority"):
        """Take a TransformStamped."""
        self._buffer.set_transform(transform, authority)

    def canTransform(self, target_frame, source_frame, time):
        """True when `lookupTransform` would give an answer."""
        return self._buffer.can_transform(
            strip_leading_slash(target_frame), strip_leading_slash(source_frame), time
        )

    def canTransformFull(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """The same between two times."""
        return self._buffer.can_transform_full(
            *_between(target_frame, target_time, source_frame, source_time, fixed_frame),
        )

    def waitForTransform(self, target_frame, source_frame, time, timeout, polling_sleep_duration=None):
        """Wait until the transform is known.

        Raises:
            tf.Exception: It is not known in time.
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
        """The same between two times."""
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
        """The frames between the two."""
        return self._buffer.chain(target_frame, target_time, source_frame, source_time, fixed_frame)

    def lookupTransform(self, target_frame, source_frame, time):
        """[x, y, z], [x, y, z, w] of the source frame in the target frame."""
        return _parts(
            self._buffer.lookup_transform(
                strip_leading_slash(target_frame), strip_leading_slash(source_frame), time
            )
        )

    def lookupTransformFull(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """The same between two times."""
        return _parts(
            self._buffer.lookup_transform_full(
                *_between(target_frame, target_time, source_frame, source_time, fixed_frame),
            )
        )

    def lookupTwist(self, tracking_frame, observation_frame, time, averaging_interval):
        """(vx, vy, vz) m/s, (wx, wy, wz) rad/s of a frame as another sees it, averaged."""
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
        """The same, expressed in a third frame."""
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
        """The newest time for which the transform is known."""
        return self._buffer.get_latest_common_time(
            strip_leading_slash(source_frame), strip_leading_slash(dest_frame)
        )

    def frameExists(self, frame_id):
        """True for a frame whose pose in another is known; not for the root."""
        return frame_id in self.getFrameStrings()

    def getFrameStrings(self):
        """Names of those frames."""
        return self._buffer.child_frames()

    def clear(self):
        """Forget everything but static transforms."""
        self._buffer.clear()

    def setUsingDedicatedThread(self, value):
        """Say whether another thread fills this buffer, so that waiting makes sense."""
        self._using_dedicated_thread = value

    def getTFPrefix(self):
        """Always empty: tf2 has no prefixes."""
        return ""
