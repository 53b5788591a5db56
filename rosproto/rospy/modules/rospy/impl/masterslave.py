"""rospy.impl.masterslave: the names that programs import from it."""

from ._unserved import unserved

ROSHandler = unserved("rospy.impl.masterslave.ROSHandler")
apivalidate = unserved("rospy.impl.masterslave.apivalidate")
