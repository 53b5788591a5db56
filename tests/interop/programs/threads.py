"""Publishing, calling and spinning in threads."""

import queue
import threading
import time

import rospy
from std_msgs.msg import Int32
from std_srvs.srv import Trigger

rospy.init_node("th")
q = queue.Queue()
rospy.Subscriber("n", Int32, q.put)
p = rospy.Publisher("n", Int32, queue_size=100)
rospy.Service("t", Trigger, lambda r: (True, threading.current_thread().name != "MainThread"))
rospy.Service("t2", Trigger, lambda r: (True, str(threading.current_thread() is not threading.main_thread())))
while not p.get_num_connections():
    time.sleep(0.05)


def w(k):
    for i in range(20):
        p.publish(k * 100 + i)


ts = [threading.Thread(target=w, args=(k,)) for k in range(3)]
[t.start() for t in ts]
[t.join() for t in ts]
while q.qsize() < 60:
    time.sleep(0.01)
got = []
while not q.empty():
    got.append(q.get().data)
print(
    len(got),
    sorted(got)[:3],
    [sorted(x for x in got if x // 100 == k) == [x for x in got if x // 100 == k] for k in range(3)],
)
print(rospy.ServiceProxy("t2", Trigger)().message)
try:
    print(rospy.ServiceProxy("t", Trigger)().message)
except Exception as e:
    print(type(e).__name__, e)
res = []


def call():
    res.append(rospy.ServiceProxy("t2", Trigger)().success)


cs = [threading.Thread(target=call) for _ in range(5)]
[c.start() for c in cs]
[c.join() for c in cs]
print(res)


def spin_thread():
    rospy.spin()
    print("spun")


s = threading.Thread(target=spin_thread)
s.start()
again = threading.Thread(target=lambda: rospy.init_node("x"))
again.start()
again.join()
rospy.signal_shutdown("done")
s.join()
print("joined")
