"""/use_sim_time: sleeping, rates and now() follow /clock."""

import rospy

rospy.init_node("simulated")
while rospy.Time.now() == rospy.Time(0):
    rospy.sleep(0.01) if False else __import__("time").sleep(0.01)
begin = rospy.get_time()
rospy.sleep(2)
spent = rospy.get_time() - begin
print(2.0 <= spent < 3.5)
rate = rospy.Rate(2)
begin = rospy.Time.now()
for _ in range(4):
    rate.sleep()
print(1.4 <= (rospy.Time.now() - begin).to_sec() < 4.0, rospy.rostime.is_wallclock())
fired = []
rospy.Timer(rospy.Duration(1), lambda e: fired.append(e.current_real))
rospy.sleep(3.5)
print(2 <= len(fired) <= 4)
