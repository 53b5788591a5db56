"""tf.TransformListener and tf.TransformerROS."""

import tf2_ros

from .transformer import Transformer, strip_leading_slash

__all__ = ["TransformListener", "Transformer", "TransformerROS", "strip_leading_slash"]


class TransformerROS(Transformer):
    """A Transformer that also transforms stamped messages."""

    def asMatrix(self, target_frame, hdr):
        """The (4, 4) matrix from a header's frame and stamp to the target frame."""
        return self.fromTranslationRotation(*self.lookupTransform(target_frame, hdr.frame_id, hdr.stamp))

    def fromTranslationRotation(self, translation, rotation):
        """The (4, 4) matrix of a pose."""
        from .moving import pose_matrix

        return pose_matrix(translation, rotation)

    def _moved(self, how, target_frame, message):
        from . import moving

        return getattr(moving, how)(self.asMatrix(target_frame, message.header), target_frame, message)

    def transformPoint(self, target_frame, ps):
        """Transform a PointStamped."""
        return self._moved("point", target_frame, ps)

    def transformVector3(self, target_frame, v3s):
        """Transform a Vector3Stamped."""
        return self._moved("vector3", target_frame, v3s)

    def transformQuaternion(self, target_frame, ps):
        """Transform a QuaternionStamped."""
        return self._moved("quaternion", target_frame, ps)

    def transformPose(self, target_frame, ps):
        """Transform a PoseStamped."""
        return self._moved("pose", target_frame, ps)

    def transformPointCloud(self, target_frame, point_cloud):
        """Transform a sensor_msgs/PointCloud."""
        return self._moved("point_cloud", target_frame, point_cloud)


class TransformListener(TransformerROS):
    """A transformer fed by /tf and /tf_static."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self._listener = tf2_ros.TransformListener(self._buffer)
        self.setUsingDedicatedThread(True)
