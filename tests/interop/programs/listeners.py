"""SubscribeListener, AnyMsg relays, introspection."""

import rospy
from std_msgs.msg import String

rospy.init_node("listeners")
events = []


class Watcher(rospy.SubscribeListener):
    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        events.append(("came", topic_name))
        peer_publish(String("welcome"))

    def peer_unsubscribe(self, topic_name, num_peers):
        events.append(("went", topic_name, num_peers))


pub = rospy.Publisher("greeting", String, subscriber_listener=Watcher(), queue_size=3)
any_messages = []
rospy.Subscriber("given", rospy.AnyMsg, any_messages.append)
while not (events and any_messages):
    rospy.sleep(0.01)
print(events)
raw = any_messages[0]
print(type(raw).__name__, raw._buff, raw._connection_header["type"], isinstance(raw, rospy.Message))
relay = rospy.Publisher("relayed", String, queue_size=1, latch=True)
while not relay.get_num_connections():
    rospy.sleep(0.05)
relay.publish(raw)
print(String().deserialize(raw._buff).data)
while rospy.get_param("/heard/ear", 0) < 1 or rospy.get_param("/heard/other_ear", 0) < 1:
    rospy.sleep(0.01)
