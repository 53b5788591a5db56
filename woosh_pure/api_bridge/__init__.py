"""A robot that has only the Robot API, as a ROS 1 graph in this process. Needs the extra `api`."""
