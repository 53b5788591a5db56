# ruff: noqa: E741, F821
"""Callbacks that raise, with and without callback_args."""

import rospy
from std_msgs.msg import Int8

rospy.init_node("u")


def cb(m):
    if m.data % 2:
        raise ValueError("odd %d" % m.data)
    print("even", m.data)


def cb2(m, args):
    print(args, m.data)
    args.append(m.data)


def cb3(m):
    undefined_name


l = []
rospy.Subscriber("n", Int8, cb)
rospy.Subscriber("n", Int8, cb2, l)
rospy.Subscriber("n", Int8, cb2, callback_args=(1, 2))
rospy.Subscriber("n", Int8, callback=cb3)
rospy.Subscriber("n", Int8, lambda: None)
through = []
rospy.Subscriber("n", Int8, through.append)  # the last that is called
p = rospy.Publisher("n", Int8, queue_size=10)
while p.get_num_connections() < 1:
    rospy.sleep(0.05)
for i in range(3):
    p.publish(i)
    while len(through) <= i:
        rospy.sleep(0.01)
print(l)
