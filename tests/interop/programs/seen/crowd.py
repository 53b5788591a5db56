"""Many threads: publishers from each, a lock around a dictionary, services called in parallel, an executor."""

import threading
from concurrent.futures import ThreadPoolExecutor

import rospy
from roscpp.srv import GetLoggers
from std_msgs.msg import Int64
from std_srvs.srv import SetBool

rospy.init_node("crowd")
lock = threading.Lock()
sums, names = {}, set()


def on_number(msg):
    with lock:
        sums[msg.data // 1000] = sums.get(msg.data // 1000, 0) + msg.data % 1000
        names.add(threading.current_thread() is threading.main_thread())


rospy.Subscriber("numbers", Int64, on_number)
pub = rospy.Publisher("numbers", Int64, queue_size=1000)
busy = [0, 0]


def slow(req):
    with lock:
        busy[0] += 1
        busy[1] = max(busy)
    while busy[1] < 2:  # until another one is in here
        rospy.sleep(0.01)
    with lock:
        busy[0] -= 1
    return {"success": req.data, "message": "done"}


rospy.Service("slow", SetBool, slow)
while not pub.get_num_connections():
    rospy.sleep(0.02)


def work(i):
    for j in range(50):
        pub.publish(i * 1000 + j)
    return i


with ThreadPoolExecutor(8) as pool:
    print(sorted(pool.map(work, range(8))))
    calls = [pool.submit(rospy.ServiceProxy("slow", SetBool), True) for _ in range(4)]
    print([c.result().success for c in calls], busy[1] > 1)
while sum(list(sums.values())) < 8 * 1225:
    rospy.sleep(0.02)
print(sorted(sums.items()), names)
proxy = rospy.ServiceProxy("slow", SetBool, persistent=True)
with ThreadPoolExecutor(1) as pool:  # a persistent proxy of rospy's belongs to one thread
    print(sorted(r.message for r in pool.map(lambda b: proxy(b), [True, False])))
proxy.close()
rospy.wait_for_service("~get_loggers", 5)
print(any(x.name == "rosout" for x in rospy.ServiceProxy("~get_loggers", GetLoggers)().loggers))
