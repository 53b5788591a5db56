"""An uncaught error ends with 1; hooks run at exit all the same."""

import rospy
from std_srvs.srv import Trigger

rospy.init_node("uncaught")
rospy.on_shutdown(lambda: print("hook"))
rospy.logwarn("about to %s", "fail")
rospy.ServiceProxy("/missing", Trigger)()
