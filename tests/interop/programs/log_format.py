# ruff: noqa: E402
"""ROSCONSOLE_FORMAT with logger, node, line and function, methods too."""

import io
import re
import sys
import threading

import rospy

rospy.init_node("fmt", log_level=rospy.WARN)


def f():
    rospy.logwarn("in f")
    rospy.loginfo("not shown")


class K:
    def m(self):
        rospy.logerr("in m")


import os


class W(io.StringIO):
    pass


f()
K().m()
(lambda: rospy.logwarn("lam"))()
rospy.logwarn_once("x")
rospy.logwarn_throttle(1, "y")
rospy.logerr("named", logger_name="sub.logger")
