"""Values that do not fit: genpy's words."""

import rospy
from geometry_msgs.msg import PoseStamped, Twist, Vector3
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, ByteMultiArray, Float64, Header, Int8, String, Time, UInt8, UInt64

rospy.init_node("wrong")
pubs = {}
for kind in (Int8, UInt8, UInt64, Float64, Bool, String, Time, Twist, LaserScan, PoseStamped):
    pubs[kind] = rospy.Publisher("t_" + kind.__name__.lower(), kind, queue_size=1)
rospy.Publisher("lonely", UInt8, queue_size=1).publish(4000)
print("not checked without subscriber")
while not all(p.get_num_connections() for p in pubs.values()):
    rospy.sleep(0.05)
for kind, values in (
    (Int8, (200, "x", 1.5, None)),
    (UInt8, (256, -1, "x")),
    (UInt64, (-1, 2**64, 1.0)),
    (Float64, ("x", [1])),
    (Bool, ("x",)),
    (String, (5, None, ["x"])),
    (Time, (5, rospy.Duration(1))),
    (Twist, (5, Vector3("a", 0, 0))),
):
    for value in values:
        try:
            if kind is Twist:
                pubs[kind].publish(Twist(linear=value))
            elif value is None:
                message = kind()
                message.data = None
                pubs[kind].publish(message)
            else:
                message = kind()
                message.data = value
                pubs[kind].publish(message)
            print(kind.__name__, value, "taken")
        except Exception as e:
            print(
                kind.__name__,
                value,
                type(e).__module__,
                type(e).__name__,
                str(e).split(" when writing")[0][:60],
            )
for message in (
    LaserScan(ranges="abc"),
    LaserScan(ranges=[1, "x"]),
    LaserScan(ranges=5),
    LaserScan(header=5),
    PoseStamped(pose=Vector3()),
):
    try:
        pubs[type(message)].publish(message)
        print("taken")
    except Exception as e:
        print(type(e).__name__, str(e).split(" when writing")[0][:60])
for call in (
    lambda: String("a", "b"),
    lambda: String(nope=1),
    lambda: String("a", data="b"),
    lambda: setattr(String(), "nope", 1),
    lambda: Header().nope,
    lambda: pubs[String].publish(Header()),
    lambda: pubs[Twist].publish(Header()),
    lambda: rospy.Publisher("x", None, queue_size=1),
    lambda: rospy.Publisher("x", 5, queue_size=1),
    lambda: rospy.Publisher("x", int, queue_size=1),
    lambda: rospy.Publisher("", String, queue_size=1),
    lambda: rospy.Subscriber("x", String, queue_size=0),
):
    try:
        print("taken", call())
    except Exception as e:
        print(type(e).__name__, str(e)[:70])
