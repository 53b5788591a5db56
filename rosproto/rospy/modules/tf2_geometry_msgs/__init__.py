"""tf2_geometry_msgs: transforms stamped geometry messages. Programs also import the module inside, as in ROS."""

from .tf2_geometry_msgs import *
