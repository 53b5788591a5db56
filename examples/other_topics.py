"""Topics of the chassis that have no property or verb: all can be used, except velocities."""

from _robot import robot

from msgdefs.woosh_msgs.msg import Charge
from woosh_pure import MotionRefused

with robot() as chassis:
    # The message itself is the value. A type that is not bundled is learned from the robot when it connects.
    links = chassis.feed("/tf_static").wait(timeout=5, new=False)
    print("fixed parts:", *(link.child_frame_id for link in links.transforms))

    chassis.send("/charge_cmd", Charge())
    try:
        chassis.send("/key_cmd_vel", Charge())
    except MotionRefused as refused:
        print("refused:", refused)
