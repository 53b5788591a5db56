"""A watchdog by rospy.Timer: stops the robot when commands stop, reports by a latched topic, once and again."""

import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import Bool, Empty


class Watchdog:
    def __init__(self, timeout):
        self.timeout = rospy.Duration(timeout)
        self.last = None
        self.stale = True
        self.events = []
        self.out = rospy.Publisher("cmd_safe", Twist, queue_size=5)
        self.status = rospy.Publisher("stale", Bool, queue_size=5, latch=True)
        rospy.Subscriber("cmd", Twist, self.on_command)
        rospy.Subscriber("reset", Empty, self.on_reset)
        self.timer = rospy.Timer(rospy.Duration(0.02), self.check)

    def on_command(self, msg):
        self.last = rospy.Time.now()
        if self.stale:
            self.stale = False
            self.events.append("fresh")
            self.status.publish(False)
        self.out.publish(msg)

    def on_reset(self, _):
        self.events.append("reset")

    def check(self, event):
        assert isinstance(event, rospy.timer.TimerEvent)
        if self.last is not None and not self.stale and rospy.Time.now() - self.last > self.timeout:
            self.stale = True
            self.events.append("stale")
            self.out.publish(Twist())
            self.status.publish(True)


rospy.init_node("watchdog", log_level=rospy.WARN)
rospy.loginfo("not seen")
dog = Watchdog(1000)
safe = []
rospy.Subscriber("cmd_safe", Twist, lambda m: safe.append(m.linear.x))
cmd, reset = rospy.Publisher("cmd", Twist, queue_size=5), rospy.Publisher("reset", Empty, queue_size=1)
while not (cmd.get_num_connections() and reset.get_num_connections() and dog.out.get_num_connections()):
    rospy.sleep(0.02)
for value in (0.1, 0.2):
    cmd.publish(Twist(linear=type(Twist().linear)(value, 0, 0)))
while len(safe) < 2:
    rospy.sleep(0.01)
dog.timeout = rospy.Duration(0.25)  # now that both have come
while dog.events[-1:] != ["stale"]:
    rospy.sleep(0.02)
reset.publish()
while "reset" not in dog.events:
    rospy.sleep(0.01)
cmd.publish(Twist())
while dog.events.count("stale") < 2 or len(safe) < 5:
    rospy.sleep(0.02)
dog.timer.shutdown()
dog.timer.join(2)
print(sorted(dog.events), dog.events[0], dog.events[-1], safe, dog.timer.is_alive())
print(rospy.wait_for_message("stale", Bool, 20))
once = []
rospy.Timer(rospy.Duration(0.05), lambda e: once.append(e.last_real), oneshot=True).join(5)
print(once)
