"""A slow callback: queue_size=1 sees the newest, none sees all, in order and in one thread."""

import threading

import rospy
from std_msgs.msg import UInt64

rospy.init_node("queues")
slow, every, threads = [], [], set()


def one(message):
    slow.append(message.data)
    rospy.sleep(0.4)


def all_of_them(message):
    threads.add(threading.current_thread().ident)
    every.append(message.data)
    if len(every) < 5:
        rospy.sleep(0.1)


a = rospy.Subscriber("numbers_a", UInt64, one, queue_size=1)
b = rospy.Subscriber("numbers_b", UInt64, all_of_them)
while not every or every[-1] != 99 or not slow or slow[-1] != 99:
    rospy.sleep(0.02)
print(every == list(range(100)), len(threads), slow[-1], len(slow) < 90, slow == sorted(slow))
a.unregister()
b.unregister()
b.unregister()
