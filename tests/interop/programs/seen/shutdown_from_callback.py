"""A node that ends itself: signal_shutdown in a callback, hooks, loops and sleeps that notice."""

import sys
import threading

import rospy
from std_msgs.msg import Empty, Int32

rospy.init_node("ender")
order, over = [], threading.Event()
rospy.on_shutdown(lambda: order.append("first"))
pub = rospy.Publisher("count", Int32, queue_size=10)


def at_end():
    order.append("second")
    pub.publish(-1)
    print("hooks see shutdown:", rospy.is_shutdown(), rospy.core.is_shutdown_requested())
    over.set()


rospy.on_shutdown(at_end)


def on_count(msg):
    order.append(msg.data)
    if msg.data == 3:
        rospy.signal_shutdown("reached three")


rospy.Subscriber("count", Int32, on_count)
stop = rospy.Subscriber("stop", Empty, lambda m: rospy.signal_shutdown("told"))


def background():
    rate = rospy.Rate(100)
    try:
        while not rospy.is_shutdown():
            rate.sleep()
    except rospy.ROSInterruptException:
        pass
    order.append("background over")


thread = threading.Thread(target=background)
thread.start()
while not pub.get_num_connections():
    rospy.sleep(0.02)
try:
    for i in (1, 2, 3):
        pub.publish(i)
        while i not in order:
            rospy.sleep(0.01)
    while not rospy.is_shutdown():
        rospy.sleep(0.01)
except rospy.ROSInterruptException as e:
    order.append("interrupted")
thread.join(20)
over.wait(20)  # the hooks run in the thread of the callback
print(sorted(map(str, order)), thread.is_alive())
try:
    rospy.wait_for_message("never", Empty, timeout=1)
except (rospy.ROSException, rospy.ROSInterruptException) as e:
    print(type(e).__name__)
try:
    rospy.wait_for_service("never", timeout=1)
except (rospy.ROSException, rospy.ROSInterruptException) as e:
    print(type(e).__name__)
pub.publish(9)
sys.exit(3)
