"""A filter node: a scan in, a scan out with other ranges, statistics by a timer, parameters read at each scan."""

import copy

import rospy
from sensor_msgs.msg import LaserScan

rospy.init_node("laser_filter")
pub = rospy.Publisher("scan_filtered", LaserScan, queue_size=10)
rospy.set_param("~max", 5.0)


def on_scan(scan):
    limit = rospy.get_param_cached("~max")
    out = copy.deepcopy(scan)
    out.header.frame_id = "filtered"
    ranges = list(scan.ranges)
    for i, r in enumerate(ranges):
        if r > limit or r != r:
            ranges[i] = float("inf")
        elif 0 < i < len(ranges) - 1:
            ranges[i] = sorted((scan.ranges[i - 1], r, scan.ranges[i + 1]))[1]
    out.ranges = ranges
    out.intensities = []
    pub.publish(out)
    scan.header.frame_id = "touched"


got = []
rospy.Subscriber("scan", LaserScan, on_scan, queue_size=1)
rospy.Subscriber("scan_filtered", LaserScan, got.append, queue_size=1)
source = rospy.Publisher("scan", LaserScan, queue_size=10)
while not (source.get_num_connections() and pub.get_num_connections()):
    rospy.sleep(0.02)
scan = LaserScan(range_max=30, scan_time=0.1, ranges=[1, 9, 2, 3, 50, 4, float("nan"), 1])
scan.intensities = [100.0] * 8
for i, limit in enumerate((5.0, 20.0)):
    rospy.set_param("~max", limit)
    while rospy.get_param_cached("~max") != limit:  # the master tells of it
        rospy.sleep(0.01)
    source.publish(scan)
    while len(got) <= i:
        rospy.sleep(0.01)
for m in got:
    print(m.header.frame_id, m.header.seq, m.ranges, m.intensities, round(m.scan_time, 4), m.range_max)
print(scan.header.frame_id, scan.header.seq, scan.ranges, isinstance(got[0].ranges, tuple))
