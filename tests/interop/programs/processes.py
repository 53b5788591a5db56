"""Two forked children, each a node of its own; messages travel by pickle."""

import multiprocessing

import rospy
from std_msgs.msg import String


def child(number, queue):
    rospy.init_node("child_%d" % number, disable_signals=True)
    pub = rospy.Publisher("from_children", String, queue_size=10)
    while not pub.get_num_connections():
        rospy.sleep(0.05)
    message = String("from %d" % number)
    pub.publish(message)
    while rospy.get_param("/heard/ear", 0) < 2:
        rospy.sleep(0.02)
    queue.put(message)


if __name__ == "__main__":
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    children = [context.Process(target=child, args=(n, queue)) for n in range(2)]
    for c in children:
        c.start()
    got = sorted(queue.get(timeout=20).data for _ in children)
    for c in children:
        c.join()
    print(got, [c.exitcode for c in children])
