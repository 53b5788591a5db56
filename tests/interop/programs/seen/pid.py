"""A controller on Float64 topics: gains from parameters, anti-windup, a plant in the same program."""

import rospy
from std_msgs.msg import Bool, Float64


class PID:
    def __init__(self, kp=1.0, ki=0.0, kd=0.0, limit=None):
        self.kp, self.ki, self.kd, self.limit = kp, ki, kd, limit
        self.integral = 0.0
        self.previous = None

    def __call__(self, error, dt):
        self.integral += error * dt
        derivative = 0.0 if self.previous is None else (error - self.previous) / dt
        self.previous = error
        out = self.kp * error + self.ki * self.integral + self.kd * derivative
        if self.limit is not None and abs(out) > self.limit:
            self.integral -= error * dt
            out = max(-self.limit, min(self.limit, out))
        return out


rospy.init_node("pid_controller")
rospy.set_param("~gains", {"p": 2.0, "i": 0.5, "d": 0.1})
gains = rospy.get_param("~gains")
pid = PID(gains["p"], rospy.get_param("~gains/i"), gains.get("d", 0), limit=rospy.get_param("~limit", 1.0))
effort = rospy.Publisher("control_effort", Float64, queue_size=10)
enable = rospy.Publisher("pid_enable", Bool, queue_size=1, latch=True)
enable.publish(True)
state, efforts = [0.0], []


def plant(msg):
    state[0] += msg.data * 0.1
    efforts.append(msg.data)


rospy.Subscriber("control_effort", Float64, plant)
assert rospy.wait_for_message("pid_enable", Bool, timeout=20).data
while not effort.get_num_connections():
    rospy.sleep(0.02)
for i in range(30):
    effort.publish(pid(1.0 - state[0], 0.1))
    while len(efforts) <= i:
        rospy.sleep(0.002)
print(["%.4f" % e for e in efforts[::5]], "%.4f" % state[0])
rospy.delete_param("~gains/d")
print(sorted(rospy.get_param("~gains").items()), rospy.has_param("~gains/d"), rospy.get_param("~gains/d", 7))
