"""Packages: which there are, and what a bag that is read says of its compression."""

import importlib
import os
import tempfile

import rosbag
import roslib
from std_msgs.msg import Int32

for name in ("std_msgs", "rospy", "std_srvs", "no_such_package"):
    try:
        print(name, roslib.load_manifest(name))
    except Exception as error:
        print(type(error).__name__, str(error).splitlines()[0])

for name in (
    "std_srvs.msg",
    "std_srvs.srv",
    "geometry_msgs.srv",
    "std_msgs.srv",
    "sensor_msgs.srv",
    "nav_msgs.msg",
):
    try:
        print(importlib.import_module(name).__name__)
    except ImportError as error:
        print(error)

path = os.path.join(tempfile.mkdtemp(), "a.bag")
with rosbag.Bag(path, "w", compression="bz2") as bag:
    for i in range(100):
        bag.write("/number", Int32(data=i))
    print(bag.compression)
with rosbag.Bag(path) as bag:
    print(bag.compression, bag.options, bag.get_compression_info().uncompressed)
os.remove(path)
os.rmdir(os.path.dirname(path))
