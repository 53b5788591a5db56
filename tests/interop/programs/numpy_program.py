"""numpy_msg in both directions."""

import numpy
import rospy
from rospy.numpy_msg import numpy_msg
from sensor_msgs.msg import LaserScan
from std_msgs.msg import UInt8MultiArray

rospy.init_node("numpy_program")
scan = rospy.wait_for_message("scan", numpy_msg(LaserScan), timeout=20)
print(type(scan.ranges).__name__, scan.ranges.dtype, float(scan.ranges.sum()), len(scan.intensities))
plain = rospy.wait_for_message("scan", LaserScan, timeout=20)
print(type(plain.ranges).__name__, plain.ranges, plain.header.frame_id, bool(plain.intensities))
pub = rospy.Publisher("doubled", numpy_msg(LaserScan), queue_size=2)
while not pub.get_num_connections():
    rospy.sleep(0.05)
out = LaserScan()
out.ranges = numpy.array(scan.ranges * 2, dtype=numpy.float32)
out.intensities = [1, 2.5]
pub.publish(out)
pub.publish(ranges=numpy.arange(3, dtype=numpy.float32))
data = rospy.wait_for_message("bytes", UInt8MultiArray, timeout=20)
print(type(data.data).__name__, data.data)
while rospy.get_param("/heard/ear", 0) < 2:
    rospy.sleep(0.01)
