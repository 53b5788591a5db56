"""Logging: every level on /rosout, named loggers, throttles, a subscriber that filters by node and level."""

import logging

import rospy
from rosgraph_msgs.msg import Log

rospy.init_node("rosout_watch", log_level=rospy.DEBUG)
lines = []


def on_log(msg):
    if msg.name == rospy.get_name() and msg.msg.startswith("*"):
        lines.append((msg.level, msg.msg, msg.function, msg.file, msg.line > 0, len(msg.topics) > 0))


rospy.Subscriber("/rosout", Log, on_log)
while not rospy.Publisher("/rosout", Log, queue_size=100).get_num_connections():
    rospy.sleep(0.02)


class Driver:
    def __init__(self):
        rospy.loginfo("*created %s", self.__class__.__name__)

    def work(self):
        rospy.logwarn("*working at %d%%", 50)
        for i in range(5):
            rospy.loginfo_throttle(60, "*throttled %d" % i)
            rospy.logwarn_once("*once")
            rospy.logerr_throttle_identical(60, "*same")


rospy.logdebug("*debug 1")
Driver().work()
rospy.logfatal("*fatal")
rospy.logerr("*%s and %r", "text", [1])
rospy.loginfo("*child", logger_name="child")
logging.getLogger("rosout").warning("*by logging")
logging.getLogger("rosout.mine").info("*mine")
try:
    1 / 0
except ZeroDivisionError:
    rospy.logerr("*caught", exc_info=False)
rospy.loginfo("*%")
rospy.loginfo("*{} %s".format(1), 2)
while len(lines) < 14:
    rospy.sleep(0.02)
for line in lines:
    print(line)
