"""tf's listener over tf2's buffer: lookups give [x, y, z], [x, y, z, w]; matrices (4, 4) move messages."""

import rospy
import tf2_ros
from geometry_msgs.msg import (
    Point,
    PointStamped,
    Pose,
    PoseStamped,
    Quaternion,
    QuaternionStamped,
    Vector3,
    Vector3Stamped,
)

import tf  # for tf.transformations, which is imported on first use


def __getattr__(name):
    if name == "transformations":
        return tf.transformations
    raise AttributeError("module %r has no attribute %r" % (__name__, name))


_ALONE = "cannot wait for transform without a dedicated thread that listens to incoming TF messages"


def strip_leading_slash(name):
    """The tf2 name: without the leading slash."""
    return name[1:] if name.startswith("/") else name


def _pair(target_frame, source_frame):
    return strip_leading_slash(target_frame), strip_leading_slash(source_frame)


def _between(target_frame, target_time, source_frame, source_time, fixed_frame):
    """Arguments of a lookup between two times, with tf2 frame names."""
    target, source = _pair(target_frame, source_frame)
    return target, target_time, source, source_time, strip_leading_slash(fixed_frame)


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
        return self._buffer.all_frames_as_dot(current_time or None)

    def allFramesAsString(self):
        """All frames with their parents."""
        return self._buffer.all_frames_as_string()

    def setTransform(self, transform, authority="default_authority"):
        """Store a TransformStamped."""
        self._buffer.set_transform(transform, authority)

    def canTransform(self, target_frame, source_frame, time):
        """True if `lookupTransform` would succeed."""
        return self._buffer.can_transform(*_pair(target_frame, source_frame), time)

    def canTransformFull(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """As `canTransform`, between two times."""
        return self._buffer.can_transform_full(
            *_between(target_frame, target_time, source_frame, source_time, fixed_frame)
        )

    def waitForTransform(self, target_frame, source_frame, time, timeout, polling_sleep_duration=None):
        """Wait until the transform is available.

        Raises:
            tf.Exception: The transform is not available within `timeout`.
        """
        arguments = (*_pair(target_frame, source_frame), time, timeout)
        self._wait(self._buffer.can_transform, arguments, target_frame, source_frame)

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
        arguments = (*_between(target_frame, target_time, source_frame, source_time, fixed_frame), timeout)
        self._wait(self._buffer.can_transform_full, arguments, target_frame, source_frame)

    def _wait(self, can, arguments, target_frame, source_frame):
        if not self._using_dedicated_thread:
            raise tf2_ros.TransformException(_ALONE)
        done, why = can(*arguments, return_debug_tuple=True)
        if not done:
            raise tf2_ros.TransformException(
                why or 'no such transformation: "%s" -> "%s"' % (source_frame, target_frame)
            )

    def chain(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """Frames between source and target."""
        return self._buffer.chain(target_frame, target_time, source_frame, source_time, fixed_frame)

    def lookupTransform(self, target_frame, source_frame, time):
        """Pose of the source frame in the target frame: [x, y, z] in m, [x, y, z, w]."""
        return _parts(self._buffer.lookup_transform(*_pair(target_frame, source_frame), time))

    def lookupTransformFull(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """As `lookupTransform`, between two times."""
        return _parts(
            self._buffer.lookup_transform_full(
                *_between(target_frame, target_time, source_frame, source_time, fixed_frame)
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
        import numpy

        latest = self.getLatestCommonTime(observation_frame, tracking_frame)
        at = time or latest
        end = min(at + rospy.Duration(0.5 * averaging_interval.to_sec()), latest)
        begin = max(rospy.Time(0.0001) + averaging_interval, end) - averaging_interval
        seconds = (end - begin).to_sec()
        matrix_of = tf.transformations.quaternion_matrix
        was, was_turned = self.lookupTransform(observation_frame, tracking_frame, begin)
        is_, is_turned = self.lookupTransform(observation_frame, tracking_frame, end)
        turn = numpy.linalg.inv(matrix_of(was_turned)) @ matrix_of(is_turned)
        angle, axis, _ = tf.transformations.rotation_from_matrix(turn)
        velocity = [(b - a) / seconds for a, b in zip(was, is_)]
        rate = [part * angle / seconds for part in axis]
        back, back_turned = self.lookupTransform(reference_frame, tracking_frame, at)
        rotation = matrix_of(back_turned)[:3, :3]
        rate = rotation @ rate
        velocity = rotation @ velocity + numpy.cross(back, rate)
        origin = numpy.array((*back, 1))
        pose = _pose_matrix(*self.lookupTransform(reference_frame, reference_point_frame, at))
        offset = pose @ origin - origin
        velocity += numpy.dot(rate, offset[:3])  # adds a scalar to each component, as tf does
        return tuple(velocity), tuple(rate)

    def getLatestCommonTime(self, source_frame, dest_frame):
        """The newest time for which the transform is available."""
        return self._buffer.get_latest_common_time(*_pair(source_frame, dest_frame))

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


def _pose_matrix(translation, rotation):
    return tf.transformations.translation_matrix(translation) @ tf.transformations.quaternion_matrix(rotation)


def xyz_to_mat44(pos):
    """The (4, 4) matrix of a Point or Vector3."""
    return tf.transformations.translation_matrix((pos.x, pos.y, pos.z))


def xyzw_to_mat44(ori):
    """The (4, 4) matrix of a Quaternion."""
    return tf.transformations.quaternion_matrix((ori.x, ori.y, ori.z, ori.w))


def _times(matrix, v):
    return (matrix @ (v.x, v.y, v.z, 1.0)).tolist()[:3]


class TransformerROS(Transformer):
    """A Transformer that also transforms stamped messages."""

    def asMatrix(self, target_frame, hdr):
        """The (4, 4) matrix from a header's frame and stamp to the target frame."""
        return self.fromTranslationRotation(*self.lookupTransform(target_frame, hdr.frame_id, hdr.stamp))

    def fromTranslationRotation(self, translation, rotation):
        """The (4, 4) matrix of a pose."""
        return _pose_matrix(translation, rotation)

    def _moved(self, cls, target_frame, message):
        """(an empty message in the target frame, the matrix to there)."""
        result = cls()
        result.header.stamp, result.header.frame_id = message.header.stamp, target_frame
        return result, self.asMatrix(target_frame, message.header)

    def transformPoint(self, target_frame, ps):
        """Transform a PointStamped."""
        result, matrix = self._moved(PointStamped, target_frame, ps)
        result.point = Point(*_times(matrix, ps.point))
        return result

    def transformVector3(self, target_frame, v3s):
        """Transform a Vector3Stamped."""
        result, matrix = self._moved(Vector3Stamped, target_frame, v3s)
        matrix[:3, 3] = 0.0
        result.vector = Vector3(*_times(matrix, v3s.vector))
        return result

    def transformQuaternion(self, target_frame, ps):
        """Transform a QuaternionStamped."""
        result, matrix = self._moved(QuaternionStamped, target_frame, ps)
        turned = matrix @ xyzw_to_mat44(ps.quaternion)
        result.quaternion = Quaternion(*tf.transformations.quaternion_from_matrix(turned).tolist())
        return result

    def transformPose(self, target_frame, ps):
        """Transform a PoseStamped."""
        result, matrix = self._moved(PoseStamped, target_frame, ps)
        moved = matrix @ (xyz_to_mat44(ps.pose.position) @ xyzw_to_mat44(ps.pose.orientation))
        result.pose = Pose(
            Point(*tf.transformations.translation_from_matrix(moved).tolist()),
            Quaternion(*tf.transformations.quaternion_from_matrix(moved).tolist()),
        )
        return result

    def transformPointCloud(self, target_frame, point_cloud):
        """Transform a sensor_msgs/PointCloud."""
        from sensor_msgs.msg import PointCloud

        result, matrix = self._moved(PointCloud, target_frame, point_cloud)
        result.channels = point_cloud.channels
        result.points = [Point(*_times(matrix, one)) for one in point_cloud.points]
        return result


class TransformListener(TransformerROS):
    """A transformer fed by /tf and /tf_static."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self._listener = tf2_ros.TransformListener(self._buffer)
        self.setUsingDedicatedThread(True)
