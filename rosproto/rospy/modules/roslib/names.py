"""roslib.names: rosgraph's, under its old name."""

from rosgraph.names import *
