"""Log functions with odd arguments, tracebacks, child loggers, throttled from loops."""

import logging
import sys

import rospy

rospy.init_node("logger", log_level=rospy.DEBUG)
rospy.logdebug("d %s", "x")
rospy.loginfo("i %d %.2f", 3, 2.5)
rospy.logwarn("w {}".format(4))
rospy.logerr("e")
rospy.logfatal("f")
rospy.loginfo(5)
rospy.loginfo(None)
rospy.loginfo([1, 2])
rospy.loginfo({"a": 1})
rospy.loginfo(ValueError("as message"))
rospy.loginfo("percent %")
rospy.loginfo("100% done")
try:
    rospy.loginfo("%s and %s", "only one")
except Exception as e:
    print(type(e), e)
try:
    rospy.loginfo("%d", "notint")
except Exception as e:
    print(type(e), e)
rospy.loginfo("%(a)s %(b)d", {"a": "dict", "b": 2})
rospy.loginfo("multi\nline")
rospy.loginfo("")
rospy.loginfo("h\u00e9llo \u4e2d")
rospy.loginfo(b"bytes")
try:
    rospy.loginfo()
except TypeError as e:
    print(e)
try:
    rospy.loginfo("a", bad=1)
except TypeError as e:
    print(e)
rospy.loginfo("a", extra={"k": 1})
rospy.loginfo("named", logger_name="abc")
rospy.logdebug("named debug", logger_name="abc.d")
try:
    {}["k"]
except KeyError:
    rospy.logerr("oops", exc_info=True)
    rospy.logwarn("oops %s", sys.exc_info()[0].__name__, exc_info=1)
    logging.getLogger("rosout").exception("exception")
rospy.loginfo("stack", stack_info=False)
for i in range(4):
    rospy.loginfo_once("once")
    rospy.logwarn_once("once %d" % i)
    rospy.loginfo_throttle(100, "thr %d" % i)
    rospy.logwarn_throttle(rospy.Duration(100) if False else 100, "thrw %d", i)
    rospy.loginfo_throttle_identical(100, "ident")
    rospy.loginfo_throttle_identical(100, "ident %d" % (i // 2))
    rospy.logerr_throttle(0.0, "zero %d" % i)


def helper():
    rospy.loginfo_once("from helper")


helper()
helper()
logging.getLogger("rosout").info("rosout direct")
logging.getLogger("rosout.mine").warning("child direct")
logging.getLogger("rospy").info("rospy logger")
logging.getLogger(__name__).warning("own")
logging.warning("root w")
logging.error("root e")
logging.info("root i")
rospy.core.logerror if hasattr(rospy.core, "logerror") else print("no")
print(rospy.DEBUG, rospy.INFO, rospy.WARN, rospy.ERROR, rospy.FATAL)
sys.stdout.flush()
