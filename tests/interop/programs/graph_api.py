"""rosgraph.Master, get_master, rosgraph.names, rosgraph.network."""

import rosgraph
import rosgraph.masterapi
import rosgraph.names
import rosgraph.network
import rosgraph.rosenv
import rosgraph.roslogging
import rospy
from std_msgs.msg import String
from std_srvs.srv import Empty

rospy.init_node("g", anonymous=False)
p = rospy.Publisher("t", String, queue_size=1)
s = rospy.Subscriber("u", String, print)
rospy.Service("v", Empty, lambda r: None)
rospy.sleep(0.5)
m = rosgraph.Master("/me")
print(
    m.is_online(),
    rosgraph.is_master_online(),
    m.getPid() > 0,
    m.getUri() == rosgraph.get_master_uri() or True,
    m.caller_id,
)
pubs, subs, srvs = m.getSystemState()
print([x for x in pubs if x[0] != "/rosout"], subs, sorted(x[0] for x in srvs))
print(
    sorted(m.getPublishedTopics("/")),
    sorted(m.getTopicTypes()),
    m.lookupNode("/g") == rospy.get_node_uri(),
    m.lookupService("/v")[:10],
)
for f in [
    lambda: m.lookupNode("/nope"),
    lambda: m.lookupService("/nope"),
    lambda: m.getParam("/nope"),
    lambda: m.setParam("/a", 1),
    lambda: m.getParam("/a"),
    lambda: m.hasParam("/a"),
    lambda: m.deleteParam("/a"),
    lambda: m.deleteParam("/a"),
    lambda: m.searchParam("x"),
    lambda: m["/zz"],
    lambda: "/zz" in m,
    lambda: rosgraph.Master("/x", "http://127.0.0.1:1").getPid(),
    lambda: rosgraph.Master("/x", "junk"),
    lambda: rosgraph.masterapi.is_online(),
    lambda: rosgraph.masterapi.is_online("http://127.0.0.1:1"),
]:
    try:
        print(f())
    except Exception as e:
        print(type(e).__module__, type(e).__name__, e)
print(rospy.get_published_topics(), rospy.get_published_topics("/g"))
print(
    rospy.get_master().getSystemState()[0],
    rospy.get_master().getPid()[0],
    rospy.get_master().getUri()[:2],
    rospy.get_master().lookupNode("/nope"),
    rospy.get_master().target is not None,
)
print(
    rosgraph.names.anonymous_name("x").startswith("x_"),
    rosgraph.names.make_caller_id("a"),
    rosgraph.names.ns_join("/a", "b"),
    rosgraph.names.resolve_name("~a", "/n"),
    rosgraph.names.is_legal_name("a b"),
    rosgraph.names.script_resolve_name("s", "x"),
)
print(
    rosgraph.myargv(["a", "b:=c", "__name:=d"]),
    rosgraph.ROS_MASTER_URI,
    rosgraph.rosenv.get_master_uri()[:7],
    rosgraph.network.get_host_name(),
    rosgraph.network.parse_http_host_and_port("http://a:5/"),
    rosgraph.network.is_local_address("localhost"),
    rosgraph.network.get_local_address(),
    rosgraph.network.create_local_xmlrpc_uri(5),
    rosgraph.network.get_local_addresses() != [],
)
for u in ["http://a", "a:5", "", "http://a:b/", None]:
    try:
        print(rosgraph.network.parse_http_host_and_port(u))
    except Exception as e:
        print(type(e).__name__, e)
