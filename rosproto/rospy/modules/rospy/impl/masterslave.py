"""rospy.impl.masterslave: the names that programs import from it."""

from . import _unserved

ROSHandler = _unserved.class_of("rospy.impl.masterslave.ROSHandler")
apivalidate = _unserved.function("rospy.impl.masterslave.apivalidate")
