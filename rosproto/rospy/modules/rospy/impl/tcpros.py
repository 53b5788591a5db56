"""rospy.impl.tcpros: the buffer size that programs pass to Subscriber."""

DEFAULT_BUFF_SIZE = 65536
