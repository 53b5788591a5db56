# ruff: noqa: E711, F403, F405
"""Message constructors, texts, comparison, checks of fields."""

import rospy
from geometry_msgs.msg import *
from nav_msgs.msg import *
from sensor_msgs.msg import CompressedImage, Image, Imu, JointState, Joy, LaserScan, PointCloud2, PointField
from std_msgs.msg import *

for f in [
    lambda: Point(1, 2, 3),
    lambda: Point(1, 2),
    lambda: Point(x=1),
    lambda: Point(w=1),
    lambda: Point(1, x=2),
    lambda: Point(1, 2, 3, 4),
    lambda: Point("a", "b", "c"),
    lambda: Pose(Point(1, 2, 3), Quaternion(0, 0, 0, 1)),
    lambda: Twist(),
    lambda: Header(),
    lambda: Header(1, rospy.Time(5), "f"),
    lambda: String("x"),
    lambda: String(data="\u00e9"),
    lambda: String(5),
    lambda: Int8(),
    lambda: Bool(1),
    lambda: Bool(),
    lambda: Float32(1.1),
    lambda: Float64(1e20),
    lambda: Float64(1e-7),
    lambda: ColorRGBA(1, 0, 0, 1),
    lambda: Time(rospy.Time(3)),
    lambda: Duration(rospy.Duration(-1.5)),
    lambda: Empty(),
    lambda: Empty(1),
    lambda: Joy(axes=[1.0, -0.5], buttons=[1, 0]),
    lambda: LaserScan(ranges=[1, 2]).ranges,
    lambda: Image().data,
    lambda: Image(data=[1, 2, 3]),
    lambda: Image(data="abc"),
    lambda: UInt8MultiArray(data=b"ab"),
    lambda: MultiArrayLayout([MultiArrayDimension("a", 1, 2)], 0),
    lambda: Path(poses=[PoseStamped(), PoseStamped()]),
    lambda: PoseWithCovariance().covariance,
    lambda: Imu().orientation_covariance,
    lambda: OccupancyGrid(data=[0, -1, 100]),
    lambda: Polygon([Point32(1, 2, 3)]),
    lambda: JointState(name=["a", "b"], position=[1, 2.5]),
    lambda: Char(5),
    lambda: Byte(3),
    lambda: CompressedImage(format="jpeg", data=b"\xff\xd8"),
    lambda: Point(None, None, None),
    lambda: Pose(None, None),
    lambda: Point(*[1.0] * 3),
    lambda: Point(x=4),
    lambda: PoseStamped(header=Header(frame_id="map")),
    lambda: Int8(data=None),
]:
    try:
        r = f()
        print(type(r).__name__)
        print(r)
        print(repr(r) == str(r))
    except BaseException as e:
        print(type(e).__name__, e)
p = Point(1, 2, 3)
for f in [
    lambda: p == Point(1, 2, 3),
    lambda: p == (1, 2, 3),
    lambda: p != None,
    lambda: p.w,
    lambda: setattr(p, "w", 1),
    lambda: p.__slots__,
    lambda: p._slot_types,
    lambda: p._type,
    lambda: p._md5sum,
    lambda: p._has_header,
    lambda: hash(p),
    lambda: p < p,
    lambda: [p] == [Point(1.0, 2.0, 3.0)],
    lambda: p in [Point(1, 2, 3)],
    lambda: str(p),
    lambda: p.__class__,
    lambda: type(p).__module__,
    lambda: p.__dict__,
    lambda: vars(p),
    lambda: [getattr(p, s) for s in p.__slots__],
    lambda: dir(p)[-3:],
    lambda: p._get_types(),
    lambda: isinstance(p, rospy.Message),
    lambda: bool(p),
    lambda: len(p),
    lambda: iter(p),
    lambda: p._check_types(),
    lambda: Point("a", 1, 1)._check_types(),
    lambda: String(5)._check_types(),
    lambda: Int8(300)._check_types(),
    lambda: Int8(1.0)._check_types(),
    lambda: Float32("x")._check_types(),
    lambda: Bool("x")._check_types(),
    lambda: Header(stamp=5)._check_types(),
    lambda: Twist(linear=5)._check_types(),
    lambda: Path(poses=[1])._check_types(),
    lambda: LaserScan(ranges=5)._check_types(),
    lambda: LaserScan(ranges=["a"])._check_types(),
    lambda: UInt8(-1)._check_types(),
    lambda: Image(data=[300])._check_types(),
    lambda: PoseWithCovariance(covariance=[1])._check_types(),
    lambda: String("\u00e9")._check_types(),
    lambda: JointState(name="abc")._check_types(),
    lambda: JointState(name=[1])._check_types(),
    lambda: Twist(linear=Point())._check_types(),
]:
    try:
        print(f())
    except BaseException as e:
        print(type(e).__name__, e)
