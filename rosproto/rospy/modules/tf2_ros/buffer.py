"""tf2_ros.Buffer: a buffer core with waiting lookups and the service ~tf2_frames."""

import rosgraph
import rospy
import tf2_py as tf2
from tf2_msgs.srv import FrameGraph, FrameGraphResponse

from .buffer_interface import ZERO, BufferInterface

DEFAULT_CAN_TRANSFORM_POLLING_SCALE = 0.01
MAX_JUMP = rospy.Duration(3.0)


class Buffer(tf2.BufferCore, BufferInterface):
    """Transforms of the last `cache_time` (default 10 s)."""

    def __init__(self, cache_time=None, debug=True):
        tf2.BufferCore.__init__(self, cache_time)
        BufferInterface.__init__(self)
        if debug:
            try:
                rosgraph.Master(rospy.get_name()).lookupService("~tf2_frames")
            except rosgraph.MasterException:
                self.frame_server = rospy.Service(
                    "~tf2_frames", FrameGraph, lambda request: FrameGraphResponse(self.all_frames_as_yaml())
                )
        self.CAN_TRANSFORM_POLLING_SCALE = DEFAULT_CAN_TRANSFORM_POLLING_SCALE

    def lookup_transform(self, target_frame, source_frame, time, timeout=ZERO):
        """The transform from source to target; wait for it up to `timeout`.

        Raises:
            LookupException, ConnectivityException, ExtrapolationException: The transform is not available.
        """
        self.can_transform(target_frame, source_frame, time, timeout)
        return self.lookup_transform_core(target_frame, source_frame, time)

    def lookup_transform_full(
        self, target_frame, target_time, source_frame, source_time, fixed_frame, timeout=ZERO
    ):
        """As `lookup_transform`, between two times."""
        self.can_transform_full(target_frame, target_time, source_frame, source_time, fixed_frame, timeout)
        return self.lookup_transform_full_core(
            target_frame, target_time, source_frame, source_time, fixed_frame
        )

    def can_transform(self, target_frame, source_frame, time, timeout=ZERO, return_debug_tuple=False):
        """True if the transform becomes available within `timeout`."""
        arguments = target_frame, source_frame, time
        return self._waited(self.can_transform_core, arguments, timeout, return_debug_tuple)

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
        """As `can_transform`, between two times."""
        arguments = target_frame, target_time, source_frame, source_time, fixed_frame
        return self._waited(self.can_transform_full_core, arguments, timeout, return_debug_tuple)

    def _waited(self, ask, arguments, timeout, whole):
        if timeout != ZERO:
            began = rospy.Time.now()
            pause = timeout * self.CAN_TRANSFORM_POLLING_SCALE
            # Stop waiting if the clock jumps back, as after the restart of a bag.
            while rospy.Time.now() < began + timeout and not ask(*arguments)[0]:
                if rospy.Time.now() + MAX_JUMP < began or rospy.is_shutdown():
                    break
                rospy.sleep(pause)
        result = ask(*arguments)
        return result if whole else result[0]
