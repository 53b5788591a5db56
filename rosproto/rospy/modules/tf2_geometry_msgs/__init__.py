"""tf2_geometry_msgs: transforms stamped geometry messages. Programs import the module inside, too."""

from .tf2_geometry_msgs import *
