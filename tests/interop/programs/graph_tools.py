"""rostopic and rosnode as monitors import them: who is where, what comes how often, whom to clean up."""

import sys

import rosgraph
import rosnode
import rospy
import rostopic
from geometry_msgs.msg import PointStamped
from std_msgs.msg import Empty, String
from std_srvs.srv import Trigger, TriggerResponse

rospy.init_node("watcher")
uri = rospy.get_node_uri()


def show(text):
    """Print without what differs."""
    print(str(text).replace(uri, "URI").rstrip())


publisher = rospy.Publisher("/talk", String, queue_size=10)
stamped = rospy.Publisher("/stamped", PointStamped, queue_size=10)
rospy.Service("/pull", Trigger, lambda request: TriggerResponse(True, ""))
got = []
hz, wall, filtered = (
    rostopic.ROSTopicHz(-1),
    rostopic.ROSTopicHz(4, use_wtime=True),
    rostopic.ROSTopicHz(10, filter_expr=lambda m: m.data == "even"),
)
delay, bandwidth = rostopic.ROSTopicDelay(-1), rostopic.ROSTopicBandwidth()
for measure in (hz, wall):
    rospy.Subscriber("/talk", rospy.AnyMsg, measure.callback_hz)
    rospy.Subscriber("/talk", rospy.AnyMsg, measure.callback_hz, callback_args="/talk")
rospy.Subscriber("/talk", rospy.AnyMsg, bandwidth.callback)
rospy.Subscriber("/talk", rospy.AnyMsg, got.append)
rospy.Subscriber("/stamped", PointStamped, delay.callback_delay)
through = []
rospy.Subscriber("/stamped", PointStamped, through.append)
print(hz.get_hz(), delay.get_delay(), bandwidth.print_bw(), delay.print_delay())
hz.print_hz()
hz.print_hz(["/a", "/b"])
while not (publisher.get_num_connections() and stamped.get_num_connections()):
    rospy.sleep(0.02)
for i in range(6):
    publisher.publish(String("even" if i % 2 else "odd"))
    message = PointStamped()
    message.header.stamp = rospy.Time.now() - rospy.Duration(100000)
    stamped.publish(message)
    filtered.callback_hz(String("even" if i % 2 else "odd"))
    while len(got) <= i or len(through) <= i:  # the last callbacks of the two topics
        rospy.sleep(0.005)
rate, least, most, deviation, window = hz.get_hz()
times = hz.get_times()
print(
    abs(rate * sum(times) / len(times) - 1) < 1e-6,
    (least, most) == (min(times), max(times)),
    0 < deviation < most,
    window,
    hz.get_hz() is None,
    len(hz.get_times()),
)
print(hz.get_hz("/talk")[4], hz.get_hz("/nothing"), wall.get_hz()[4], filtered.get_hz()[4])
found = delay.get_delay()
print([round(v / 1000) for v in found[:3]], found[4], delay.get_delay(), len(delay.delays))
print(bandwidth.sizes, len(bandwidth.times))
bandwidth.sizes[:] = [1500, 2500, 3500, 500, 1000, 1000]
wall.callback_hz(None)
delay.print_delay()
print(rospy.Time.now().to_time() - rospy.Time.now().to_sec() < 0.1, rospy.Time.from_seconds(1.5))
try:
    delay.callback_delay(Empty())
except Exception as error:
    print(type(error).__name__)
sys.stdout.flush()

for topic in ("/talk", "/stamped", "/rosout", "/nothing"):
    try:
        show(rostopic.get_info_text(topic))
    except rostopic.ROSTopicException as error:
        print(error)
master = rosgraph.Master("/script")
for service in ("~get_loggers", "~set_logger_level"):  # ours come a moment after init_node
    rospy.wait_for_service(service, 20)
show([rostopic.get_api(master, "/watcher"), rostopic.get_api(master, "/nobody")])
show(rosnode.get_node_info_description("/watcher"))
show(rosnode.get_node_info_description("/nobody"))
print(
    rosnode.get_machines_by_nodes(),
    rosnode.get_nodes_by_machine("127.0.0.1"),
    rosnode.get_nodes_by_machine("10.1.2.3"),
)
print(rosnode.get_nodes_by_machine("localhost"))
try:
    rosnode.get_nodes_by_machine("no.such.host.invalid")
except rosnode.ROSNodeException as error:
    print(error)
rosnode.rosnode_listnodes()
rosnode.rosnode_listnodes("/ns")
print(rosnode._sub_rosnode_listnodes().split(), [rosnode._sub_rosnode_listnodes("/ns")])
show(rosnode._sub_rosnode_listnodes(list_all=True))
print(rosnode.rosnode_ping_all(), rosnode.rosnode_ping("/watcher", max_count=1, skip_cache=True))
print(rosnode.rosnode_ping("/nobody", max_count=1), rosnode.get_api_uri(master, "/nobody"))
for name in ("/dead", "/ghost"):
    dead = rosgraph.Master(name)
    dead.registerPublisher("/old", "std_msgs/String", "http://127.0.0.1:9/")
    dead.registerSubscriber("/older", "std_msgs/String", "http://127.0.0.1:9/")
    dead.registerService("/gone", "rosrpc://127.0.0.1:9", "http://127.0.0.1:9/")
print(sorted(rosnode.get_node_names()), rosnode.rosnode_ping("/dead", max_count=1))
pinged = rosnode.rosnode_ping_all()
print(sorted(pinged[0]), sorted(pinged[1]))
rosnode.cleanup_master_blacklist(master, ["/dead"])
print(sorted(rosnode.get_node_names()))
rosnode.cleanup_master_whitelist(master, ["/watcher"])
print(sorted(rosnode.get_node_names()), rosnode.kill_nodes(["/nobody"]))
for wrong in ("nonsense", "no_such_pkg/Type"):
    try:
        rostopic.create_publisher("/made", wrong, False)
    except rostopic.ROSTopicException as error:
        print(str(error).split("\n")[0])
