"""A signal while the program sleeps, waits, spins or calls."""

import sys
import time

import rospy
from std_msgs.msg import String
from std_srvs.srv import Trigger

rospy.init_node("sig")
rospy.on_shutdown(lambda: print("hook"))
where = sys.argv[1]


def main():
    print("ready")
    sys.stdout.flush()
    if where == "sleep":
        rospy.sleep(3)
        print("slept", rospy.is_shutdown())
    elif where == "rate":
        r = rospy.Rate(0.3)
        r.sleep()
        print("rate over", rospy.is_shutdown())
        r.sleep()
    elif where == "spin":
        rospy.spin()
        print("spin over")
    elif where == "wfm":
        print(rospy.wait_for_message("never", String))
    elif where == "wfs":
        print(rospy.wait_for_service("never"))
    elif where == "loop":
        n = 0
        while not rospy.is_shutdown():
            time.sleep(0.05)
            n += 1
        print("loop over", n > 2)
    elif where == "pysleep":
        time.sleep(1.5)
        print("python slept", rospy.is_shutdown())
    elif where == "input":
        import threading

        e = threading.Event()
        print(e.wait(1.5))
    elif where == "call":
        print(rospy.ServiceProxy("/slow", Trigger)())


try:
    main()
except rospy.ROSInterruptException as e:
    print("RIE", e)
except KeyboardInterrupt:
    print("KI")
except Exception as e:
    print(type(e).__name__, e)
print("end", rospy.is_shutdown())
