"""disable_signals leaves Ctrl-C to the program."""

import sys
import time

import rospy

rospy.init_node("python_way", disable_signals=True)
rospy.on_shutdown(lambda: print("hook"))
print("ready", flush=True)
try:
    while True:
        time.sleep(0.05)
except KeyboardInterrupt:
    print("interrupted", rospy.is_shutdown())
    if "again" in sys.argv:
        raise
    rospy.signal_shutdown("done")
    sys.exit(4)
