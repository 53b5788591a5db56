"""Callbacks: errors in them, unregistering inside, two for one topic, a message's text."""

import rospy
from geometry_msgs.msg import PoseStamped

rospy.init_node("callbacks")
order = []


def failing(message):
    order.append("failing")
    raise ValueError("in a callback")


def last(message):
    order.append("last")
    sub.unregister()
    print(message)


rospy.Subscriber("pose", PoseStamped, failing)
sub = rospy.Subscriber("pose", PoseStamped, last)
through = []


def next_one(message):
    """The last that is called. What rospy reads at a time it gives to the callbacks that were there before."""
    through.append(message)
    rospy.set_param("/ready", len(through) + 1)


rospy.Subscriber("pose", PoseStamped, next_one)
rospy.set_param("/ready", 1)  # all are there: now something may come
while len(through) < 5:
    rospy.sleep(0.01)
print(order[:4], sub.impl)
try:
    rospy.Publisher("p", PoseStamped, queue_size=1).unregister()
    pub = rospy.Publisher("q", PoseStamped)
    pub.unregister()
    pub.publish(PoseStamped())
except rospy.ROSException as e:
    print(e)
