"""What a program gives up is gone: publishers, subscribers, services, proxies, timers; and the master's word for it."""

import gc
import time
import weakref
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
from std_msgs.msg import String
from std_srvs.srv import Empty, EmptyResponse

rospy.init_node("given_up", disable_rosout=True)
slave, master = ServerProxy(rospy.get_node_uri()), rosgraph.Master("/given_up")
watched = {}


class Listener(rospy.SubscribeListener):
    def peer_unsubscribe(self, topic_name, num_peers):
        gone.append((topic_name, num_peers))


def watch(**ones):
    for kind, one in ones.items():
        watched.setdefault(kind, []).append(weakref.ref(one))


def until(noted):
    end = time.time() + 10
    while not noted and time.time() < end:
        time.sleep(0.01)
    print(bool(noted))


for i in range(3):
    name, got, gone = "/kept_%d" % i, [], []
    publisher = rospy.Publisher(name, String, Listener(), latch=True, queue_size=1)
    publisher.publish("x" * 1000)
    one, other = rospy.Subscriber(name, String, got.append), rospy.Subscriber(name, String)
    until(got)
    service = rospy.Service("~empty_%d" % i, Empty, lambda request: EmptyResponse())
    proxy = rospy.ServiceProxy("~empty_%d" % i, Empty, persistent=True)
    proxy()
    timer = rospy.Timer(rospy.Duration(0.01), lambda event: None)
    watch(publisher=publisher.impl, subscriber=one.impl, service=service, proxy=proxy, timer=timer)
    print([row for row in slave.getPublications("/me")[2] if row[0] == name])
    proxy.close()
    service.shutdown()
    one.unregister()
    other.unregister()
    until(gone)
    print(gone)
    publisher.unregister()
    timer.shutdown()
    timer.join()
    print([row for row in slave.getPublications("/me")[2] if row[0] == name])
    print(master.getSystemState()[0])
del publisher, one, other, service, proxy, timer
end = time.time() + 10
while any(ref() for refs in watched.values() for ref in refs) and time.time() < end:
    gc.collect()
    time.sleep(0.05)
for kind in sorted(watched):
    print(kind, sum(ref() is not None for ref in watched[kind]))

# Given up while a subscriber is there: gone with a collection, not with the end of its link.
publisher = rospy.Publisher("/heard", String, Listener(), latch=True, queue_size=1)
publisher.publish("y" * 1000)
heard = []
rospy.Subscriber("/heard", String, heard.append)
until(heard)
ref = weakref.ref(publisher.impl)
publisher.unregister()
end = time.time() + 10
while ref() and time.time() < end:  # rospy's thread that has just sent it may still hold it
    gc.collect()
    time.sleep(0.05)
print(ref())
