"""Log lines: levels, formats, throttled, once, assigned functions, Python's logging."""

import logging

import rospy

rospy.loginfo("before init")
rospy.logwarn("warned before init")
logging.info("plain info")
rospy.init_node("logs", log_level=rospy.DEBUG)
rospy.logdebug("debug %s", 1)
rospy.loginfo("info %d and %s", 5, [1])
rospy.logwarn("warn")
rospy.logerr("error")
rospy.logfatal("fatal")
rospy.logout("out")
rospy.loginfo("100%")
rospy.loginfo("named", logger_name="sub")
for i in range(3):
    rospy.loginfo_once("once %d", i)
    rospy.logwarn_throttle(60, "throttled %d" % i)
    rospy.logerr_throttle_identical(60, "identical")
    rospy.loginfo_throttle(0, "not throttled %d" % i)
try:
    1 / 0
except ZeroDivisionError:
    rospy.logerr("with trace", exc_info=True)
logging.warning("root warning goes to the file")
logging.getLogger("rosout").info("by logging")
lines = []
rospy.loginfo = lambda *a: lines.append(a)
rospy.loginfo("kept")
print(lines)
