"""tf.TransformListener: tf2's buffer in the clothes of before."""

import rospy
import tf2_ros
from geometry_msgs.msg import PointStamped, PoseStamped, QuaternionStamped, Vector3Stamped


def strip_leading_slash(name):
    """tf2 has none."""
    return name[1:] if name.startswith("/") else name


class Transformer:
    """Lookups in tuples."""

    def __init__(self, interpolate=True, cache_time=None):
        self._buffer = tf2_ros.Buffer(cache_time, debug=False)
        self._using_dedicated_thread = True

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

    def waitForTransform(self, target_frame, source_frame, time, timeout, polling_sleep_duration=None):
        """Wait until it can be had.

        Raises:
            tf.Exception: It cannot, in time.
        """
        done, why = self._buffer.can_transform(
            strip_leading_slash(target_frame),
            strip_leading_slash(source_frame),
            time,
            timeout,
            return_debug_tuple=True,
        )
        if not done:
            raise tf2_ros.TransformException(
                why or 'no such transformation: "%s" -> "%s"' % (source_frame, target_frame)
            )

    def lookupTransform(self, target_frame, source_frame, time):
        """[x, y, z], [x, y, z, w] of the source frame in the target frame."""
        message = self._buffer.lookup_transform(
            strip_leading_slash(target_frame), strip_leading_slash(source_frame), time
        )
        t, r = message.transform.translation, message.transform.rotation
        return [t.x, t.y, t.z], [r.x, r.y, r.z, r.w]

    def lookupTransformFull(self, target_frame, target_time, source_frame, source_time, fixed_frame):
        """The same between two times."""
        message = self._buffer.lookup_transform_full(
            strip_leading_slash(target_frame),
            target_time,
            strip_leading_slash(source_frame),
            source_time,
            strip_leading_slash(fixed_frame),
        )
        t, r = message.transform.translation, message.transform.rotation
        return [t.x, t.y, t.z], [r.x, r.y, r.z, r.w]

    def getLatestCommonTime(self, source_frame, dest_frame):
        """The newest time for which it is known."""
        return self._buffer.get_latest_common_time(
            strip_leading_slash(dest_frame), strip_leading_slash(source_frame)
        )

    def frameExists(self, frame_id):
        """True for a known frame."""
        return self._buffer._frameExists(strip_leading_slash(frame_id))

    def getFrameStrings(self):
        """Names of all frames."""
        return self._buffer._getFrameStrings()

    def clear(self):
        """Forget what moves."""
        self._buffer.clear()


class TransformerROS(Transformer):
    """And transforming of stamped messages."""

    def asMatrix(self, target_frame, hdr):
        """The (4, 4) matrix that takes data with that header to a frame."""
        return self.fromTranslationRotation(*self.lookupTransform(target_frame, hdr.frame_id, hdr.stamp))

    def fromTranslationRotation(self, translation, rotation):
        """The (4, 4) matrix of a pose."""
        from . import transformations

        matrix = transformations.quaternion_matrix(rotation)
        matrix[:3, 3] = translation
        return matrix

    def _moved(self, target_frame, message):
        from tf2_ros import geometry

        functions = {
            "geometry_msgs/PointStamped": geometry.do_transform_point,
            "geometry_msgs/PoseStamped": geometry.do_transform_pose,
            "geometry_msgs/Vector3Stamped": geometry.do_transform_vector3,
        }
        transform = self._buffer.lookup_transform(
            strip_leading_slash(target_frame),
            strip_leading_slash(message.header.frame_id),
            message.header.stamp,
        )
        result = functions[message._type](message, transform)
        result.header.stamp, result.header.frame_id = message.header.stamp, target_frame
        return result

    def transformPoint(self, target_frame, ps):
        """A PointStamped in another frame."""
        return self._moved(target_frame, ps)

    def transformVector3(self, target_frame, v3s):
        """A Vector3Stamped in another frame."""
        return self._moved(target_frame, v3s)

    def transformPose(self, target_frame, ps):
        """A PoseStamped in another frame."""
        return self._moved(target_frame, ps)

    def transformQuaternion(self, target_frame, ps):
        """A QuaternionStamped in another frame."""
        pose = PoseStamped(header=ps.header)
        pose.pose.orientation = ps.quaternion
        moved = self._moved(target_frame, pose)
        return QuaternionStamped(header=moved.header, quaternion=moved.pose.orientation)

    def transformPointCloud(self, target_frame, point_cloud):
        """A sensor_msgs/PointCloud in another frame."""
        from geometry_msgs.msg import Point32
        from sensor_msgs.msg import PointCloud

        matrix = self.asMatrix(target_frame, point_cloud.header)
        result = PointCloud(channels=point_cloud.channels)
        result.header.stamp, result.header.frame_id = point_cloud.header.stamp, target_frame
        result.points = [Point32(*matrix.dot([p.x, p.y, p.z, 1.0])[:3].tolist()) for p in point_cloud.points]
        return result


class TransformListener(TransformerROS):
    """Fills itself from /tf and /tf_static."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self._listener = tf2_ros.TransformListener(self._buffer)
