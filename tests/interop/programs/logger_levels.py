# ruff: noqa: E741
"""The logger services, and handlers of the program's own."""

import logging

import rospy
from roscpp.msg import Logger
from roscpp.srv import GetLoggers, SetLoggerLevel

rospy.init_node("ll")
rospy.sleep(0.5)
rospy.wait_for_service("~set_logger_level", 3)
rospy.logdebug("hidden")
rospy.ServiceProxy("~set_logger_level", SetLoggerLevel)("rosout", "DEBUG")
rospy.logdebug("debug 1 shown")
rospy.ServiceProxy("~set_logger_level", SetLoggerLevel)("rosout", "error")
rospy.logwarn("hidden")
rospy.logerr("shown err")
for l, v in (("rosout", "nope"), ("nope", "info")):
    try:
        print(rospy.ServiceProxy("~set_logger_level", SetLoggerLevel)(l, v))
    except Exception as e:
        print(type(e).__name__, e)
ls = {l.name: l.level for l in rospy.ServiceProxy("~get_loggers", GetLoggers)().loggers}
print(ls.get("rosout"), "rospy" in ls or "rospy.core" in ls)
logging.getLogger("rosout").setLevel(logging.INFO)
rospy.loginfo("back")
h = logging.StreamHandler(__import__("sys").stdout)
h.setFormatter(logging.Formatter("H %(name)s %(levelname)s %(message)s %(funcName)s"))
logging.getLogger("rosout").addHandler(h)


def g():
    rospy.loginfo("both")


g()
