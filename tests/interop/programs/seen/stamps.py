"""Time in programs: stamps compared, ages, Duration arithmetic, rates, conversions, old and new spellings."""

import datetime
import time

import rospy
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Duration as DurationMsg
from std_msgs.msg import Header, Time

rospy.init_node("stamps")
now = rospy.Time.now()
pose = PoseStamped(header=Header(stamp=now - rospy.Duration(1.5)))
age = rospy.Time.now() - pose.header.stamp
print(
    type(age).__name__,
    age.to_sec() >= 1.5,
    age > rospy.Duration(1),
    age < rospy.Duration(60),
    age == age,
)
print(
    pose.header.stamp < now,
    pose.header.stamp != now,
    max(now, pose.header.stamp) == now,
    now.is_zero(),
    bool(rospy.Time()),
)
print(
    abs(rospy.get_time() - time.time()) < 1, abs(rospy.Time.from_sec(time.time()).to_sec() - time.time()) < 1
)
print(abs(now.to_time() - now.to_sec()) < 1e-6, now.secs == now.to_nsec() // 10**9, rospy.Time(1, 5).nsecs)
t = rospy.Time(10, 750000000)
d = rospy.Duration(0, 500000000)
for value in (t + d, t - d, t - rospy.Time(9), d * 3, d * 0.5, d / 2, d // rospy.Duration(0, 200000000), -d, abs(-d), d + d, d - d * 3,
              rospy.Duration(2.5) % rospy.Duration(1), rospy.Duration.from_sec(-1.25), rospy.Duration(3) / rospy.Duration(2)):  # fmt: skip
    print(repr(value), value)
print(
    sorted([rospy.Time(3), rospy.Time(1, 2), rospy.Time(1)]),
    {rospy.Time(1): "a"}[rospy.Time(1)],
    hash(d) == hash(rospy.Duration(0.5)),
)
print(
    datetime.datetime.fromtimestamp(t.to_sec(), datetime.timezone.utc).isoformat(),
    "%.2f" % t.to_sec(),
    "%d.%09d" % (t.secs, t.nsecs),
)
for expression in (
    "t + t",
    "t + 1",
    "d + 1",
    "t - 1",
    "t < 5",
    "d < 5",
    "rospy.Time(-1)",
    "rospy.Time('x')",
    "rospy.Duration(1.5, 3)",
    "d / 0",
):
    try:
        print(expression, eval(expression))
    except Exception as e:
        print(expression, type(e).__name__, e)
sent = [
    rospy.Publisher("t", Time, queue_size=1, latch=True),
    rospy.Publisher("d", DurationMsg, queue_size=1, latch=True),
]
sent[0].publish(t)
sent[1].publish(data=d)
print(
    repr(rospy.wait_for_message("t", Time, 20).data), repr(rospy.wait_for_message("d", DurationMsg, 20).data)
)
began = time.time()
rate = rospy.Rate(20)
for _ in range(6):
    rate.sleep()
print(time.time() - began > 0.2, rate.sleep_dur, rate.remaining() <= rospy.Duration(0.05))
rospy.sleep(rospy.Duration(0.05))
rospy.sleep(-1)
rospy.sleep(0)
rospy.rostime.wallsleep(0.01)
