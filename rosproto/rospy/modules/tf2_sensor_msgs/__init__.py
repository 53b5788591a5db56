"""tf2_sensor_msgs: transforms point clouds. Programs import the module inside, too, as in ROS."""

from .tf2_sensor_msgs import *
