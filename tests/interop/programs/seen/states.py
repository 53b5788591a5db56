"""A state machine of one's own: states as classes, a subscriber that drives it, a condition, a loop by Rate."""

import threading
from enum import Enum

import rospy
from std_msgs.msg import String


class State(Enum):
    IDLE = 0
    MOVING = 1
    CHARGING = 2
    FAULT = 3


TABLE = {
    (State.IDLE, "go"): State.MOVING,
    (State.MOVING, "arrived"): State.IDLE,
    (State.MOVING, "low"): State.CHARGING,
    (State.CHARGING, "full"): State.IDLE,
}


class Machine:
    def __init__(self):
        self.state = State.IDLE
        self.changed = threading.Condition()
        self.history = []
        self.pub = rospy.Publisher("~state", String, queue_size=10, latch=True)
        rospy.Subscriber("~event", String, self.on_event)

    def on_event(self, msg):
        with self.changed:
            self.state = TABLE.get((self.state, msg.data), State.FAULT if msg.data == "error" else self.state)
            self.history.append((msg.data, self.state.name))
            self.pub.publish(self.state.name)
            self.changed.notify_all()

    def wait_for(self, state, timeout):
        with self.changed:
            return self.changed.wait_for(lambda: self.state is state, timeout)


rospy.init_node("states")
machine = Machine()
events = rospy.Publisher("~event", String, queue_size=10)
while not events.get_num_connections():
    rospy.sleep(0.02)
for event, state in (
    ("go", State.MOVING),
    ("low", State.CHARGING),
    ("go", State.CHARGING),
    ("full", State.IDLE),
    ("error", State.FAULT),
):
    count = len(machine.history)
    events.publish(event)
    while len(machine.history) == count:
        rospy.sleep(0.01)
    print(event, machine.wait_for(state, 5), machine.state)
print(machine.history, machine.wait_for(State.IDLE, 0.1))
print(rospy.wait_for_message("~state", String, 20).data)
loop = rospy.Rate(50)
for _ in range(3):
    loop.sleep()
with machine.changed:
    machine.changed.notify_all()
try:
    raise rospy.ROSInterruptException("stop")
except Exception as e:
    print(isinstance(e, KeyboardInterrupt), isinstance(e, rospy.ROSException), e)
