"""Topics of the chassis without a verb of their own: any can be read and written, velocities apart."""

from _robot import robot

from msgdefs.woosh_msgs.msg import Charge
from woosh_pure import MotionRefused

with robot() as chassis:
    # The definition of this one is not published: it is learned from the robot when it connects.
    volume = chassis.feed("/volume/percent").wait(timeout=5, new=False)
    print("the volume topic says", *str(volume).split())

    chassis.send("/charge_cmd", Charge())
    try:
        chassis.send("/key_cmd_vel", Charge())
    except MotionRefused as refused:
        print("refused:", refused)
