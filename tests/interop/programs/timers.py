"""Timers, rates, durations, times."""

import rospy

for make in (lambda: rospy.Rate(10), rospy.Time.now, rospy.get_time, lambda: rospy.spin()):
    try:
        make()
    except rospy.ROSInitException as e:
        print(type(e).__module__, e)
rospy.sleep(0.01)
rospy.init_node("timers")
ticks, shots = [], []
timer = rospy.Timer(rospy.Duration(0.1), lambda event: ticks.append(event))
rospy.Timer(rospy.Duration(0.05), lambda event: shots.append(event), oneshot=True)
rospy.sleep(0.55)
timer.shutdown()
count = len(ticks)
rospy.sleep(0.3)
print(count in (4, 5), len(ticks) - count <= 1, len(shots))
print(
    ticks[0].last_expected, ticks[1].last_expected == ticks[0].current_expected, ticks[1].last_duration < 0.05
)
print(abs((ticks[1].current_real - ticks[0].current_real).to_sec() - 0.1) < 0.05)
rate = rospy.Rate(20)
begin = rospy.Time.now()
for _ in range(6):
    rate.sleep()
spent = rospy.Time.now() - begin
print(type(spent).__name__, abs(spent.to_sec() - 0.3) < 0.06, rospy.Duration(2) > rospy.Duration(1.5))
print(
    repr(rospy.Duration(1.5)),
    repr(rospy.Time(3, 5)),
    rospy.Duration(1) + rospy.Duration(0, 5),
    rospy.Time(5) - rospy.Time(3),
)
print(
    repr(rospy.Time(5) - rospy.Time(3)),
    repr(rospy.Time(5) + rospy.Duration(1)),
    rospy.Time.from_sec(1.25).to_nsec(),
)
print(
    rospy.Duration(5) * 2,
    rospy.Duration(5) / 2,
    repr(rospy.Duration.from_sec(-0.5)),
    abs(rospy.Duration(-3)).to_sec(),
)
print(
    rospy.Time(0) == rospy.Time(),
    rospy.Time() < rospy.Time(1),
    bool(rospy.Time()),
    hash(rospy.Time(1, 2)) == hash((1, 2)),
)
for wrong in (
    lambda: rospy.Time(-1),
    lambda: rospy.Time(1.5, 3),
    lambda: rospy.Time(1) + rospy.Time(2),
    lambda: rospy.Time(1) < 3,
):
    try:
        print(wrong())
    except Exception as e:
        print(type(e).__name__, e)


def broken(event):
    raise RuntimeError("in a timer")


rospy.Timer(rospy.Duration(0.05), broken)
rospy.sleep(0.3)
print("still here")
