"""rospy.impl: what programs reach into."""
