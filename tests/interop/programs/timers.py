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
while len(ticks) < 4 or not shots:
    rospy.sleep(0.01)
timer.shutdown()
timer.join()
count = len(ticks)
rospy.sleep(0.15)
print(len(ticks) == count, len(shots))
print(
    ticks[0].last_expected, ticks[1].last_expected == ticks[0].current_expected, ticks[1].last_duration >= 0
)
print([tick.current_expected - ticks[0].current_expected for tick in ticks[:4]])
print(all(tick.current_real - tick.current_expected > rospy.Duration(-0.02) for tick in ticks))
begin = rospy.Time.now()
rate = rospy.Rate(20)
for _ in range(6):
    rate.sleep()
spent = rospy.Time.now() - begin
print(type(spent).__name__, spent.to_sec() > 0.24, rospy.Duration(2) > rospy.Duration(1.5))
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


rospy.Timer(rospy.Duration(0.05), broken).join()
print("still here")
