"""tf2_ros: buffer, listener, broadcasters, with all names of the modules inside, as in ROS."""

from tf2_py import *

from .buffer import *
from .buffer_client import *
from .buffer_interface import *
from .static_transform_broadcaster import *
from .transform_broadcaster import *
from .transform_listener import *
