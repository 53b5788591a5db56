"""laser_geometry: LaserScan messages as clouds, in the scanner's frame (wiki.ros.org/laser_geometry)."""

import numpy
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointField


class LaserProjection:
    """Turns scans into clouds."""

    LASER_SCAN_INVALID = -1.0
    LASER_SCAN_MIN_RANGE = -2.0
    LASER_SCAN_MAX_RANGE = -3.0

    class ChannelOption:
        """What a point has besides x, y, z; to be or'ed."""

        NONE = 0x00
        INTENSITY = 0x01
        INDEX = 0x02
        DISTANCE = 0x04
        TIMESTAMP = 0x08
        VIEWPOINT = 0x10
        DEFAULT = INTENSITY | INDEX

    def projectLaser(self, scan_in, range_cutoff=-1.0, channel_options=ChannelOption.DEFAULT):
        """A PointCloud2 of the ranges from range_min to less than range_max and the cutoff.

        Args:
            scan_in: A LaserScan.
            range_cutoff: Metres; negative for none.
            channel_options: What each point has, of ChannelOption.
        """
        ranges = numpy.array(scan_in.ranges, dtype=float)
        limit = scan_in.range_max if range_cutoff < 0 else min(range_cutoff, scan_in.range_max)
        kept = numpy.flatnonzero((ranges < limit) & (ranges >= scan_in.range_min))
        ranges = ranges[kept]
        angles = scan_in.angle_min + kept * scan_in.angle_increment
        zeros = [0] * len(kept)
        columns = {"x": ranges * numpy.cos(angles), "y": ranges * numpy.sin(angles), "z": zeros}
        option = self.ChannelOption
        if channel_options & option.INTENSITY and len(scan_in.intensities):
            columns["intensity"] = numpy.array(scan_in.intensities, dtype=float)[kept]
        if channel_options & option.INDEX:
            columns["index"] = kept
        if channel_options & option.DISTANCE:
            columns["distances"] = ranges
        if channel_options & option.TIMESTAMP:
            columns["stamps"] = kept * scan_in.time_increment
        if channel_options & option.VIEWPOINT:
            columns.update(vp_x=zeros, vp_y=zeros, vp_z=zeros)
        fields = [
            PointField(name, 4 * i, PointField.INT32 if name == "index" else PointField.FLOAT32, 1)
            for i, name in enumerate(columns)
        ]
        lists = [numpy.asarray(column).tolist() for column in columns.values()]
        return point_cloud2.create_cloud(scan_in.header, fields, list(zip(*lists)))
