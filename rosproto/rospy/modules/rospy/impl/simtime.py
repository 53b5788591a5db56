"""rospy.impl.simtime: time from /clock when /use_sim_time is set."""

import logging
import traceback

from rosgraph_msgs.msg import Clock

from .. import rostime, topics

_clock_sub = None


def init_simtime():
    """Look up whether time is simulated; False when the master is unreachable."""
    global _clock_sub
    from rospy import client

    try:
        code, _, value = client.get_master().getParam("/use_sim_time")
        if code == 1 and value and _clock_sub is None:
            _clock_sub = topics.Subscriber(
                "/clock", Clock, lambda message: rostime.set_rostime(message.clock), queue_size=1
            )
            if rostime.is_wallclock():
                rostime.set_rostime(rostime.Time(0, 0))
        rostime.set_rostime_initialized(True)
        return True
    except Exception as error:
        logging.getLogger("rospy.simtime").error(
            "Unable to initialize /clock: %s\n%s", error, traceback.format_exc()
        )
        return False
