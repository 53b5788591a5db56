"""roslib.message: genpy's, under its old name."""

from genpy.message import *
