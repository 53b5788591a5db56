"""rospy.impl: rospy's internal modules, as far as programs import them."""
