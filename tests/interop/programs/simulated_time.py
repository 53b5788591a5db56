"""/use_sim_time: sleeping, rates and now() follow /clock, which runs a thousand times as fast as real time."""

import time

import rospy

rospy.init_node("simulated")
while rospy.Time.now() == rospy.Time(0):
    time.sleep(0.01)
began = time.time()
begin = rospy.get_time()
rospy.sleep(200)
print(rospy.get_time() - begin >= 200, time.time() - began < 100)
begin = rospy.Time.now()
rate = rospy.Rate(0.01)
for _ in range(4):
    rate.sleep()
print((rospy.Time.now() - begin).to_sec() >= 400, rospy.rostime.is_wallclock())
fired = []
begin = rospy.get_time()
rospy.Timer(rospy.Duration(100), lambda e: fired.append(e.current_real))
while len(fired) < 3:
    time.sleep(0.01)
print(len(fired) <= (rospy.get_time() - begin) / 100 + 1)
