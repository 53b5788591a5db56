"""Inner names of rospy, rosgraph and actionlib that public programs import, and what they do with them."""

import io
import os
import socket
from xmlrpc.client import ServerProxy

import actionlib.handle_tracker_deleter
import rosgraph.network as network
import rospy
import rospy.impl.init
import rospy.impl.rosout
import rospy.impl.simtime
from rospy.core import xmlrpcapi
from rospy.impl import masterslave, rosout, tcpros_service
from rospy.impl.init import RosStreamHandler
from rospy.impl.paramserver import get_param_server_cache
from rospy.impl.registration import (
    Registration,
    RegistrationListener,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
    set_topic_manager,
)
from rospy.impl.rosout import RosOutHandler, _rospy_to_logging_levels
from rospy.impl.statistics import SubscriberStatisticsLogger
from rospy.impl.tcpros import DEFAULT_BUFF_SIZE, get_tcpros_handler, init_tcpros
from rospy.impl.tcpros_base import TCPROS, TCPROSServer, TCPROSTransport, TCPROSTransportProtocol
from rospy.impl.tcpros_pubsub import QueuedConnection, TCPROSHandler, TCPROSPub, TCPROSSub
from rospy.impl.tcpros_service import Service, ServiceImpl, ServiceProxy, convert_return_to_response
from rospy.impl.transport import BIDIRECTIONAL, INBOUND, OUTBOUND, DeadTransport, ProtocolHandler, Transport
from rospy.impl.validators import ParameterInvalid, non_empty
from rospy.msg import deserialize_messages, serialize_message
from std_msgs.msg import String
from std_srvs.srv import Empty, EmptyResponse

imported = [
    masterslave.ROSHandler,
    tcpros_service.wait_for_service,
    RosStreamHandler,
    RosOutHandler,
    init_tcpros,
]
imported += [SubscriberStatisticsLogger, get_tcpros_handler, TCPROSServer, QueuedConnection, TCPROSHandler]
imported += [
    TCPROSPub,
    TCPROSSub,
    ServiceImpl,
    convert_return_to_response,
    ProtocolHandler,
    set_topic_manager,
]
print(all(map(callable, imported)), TCPROS, DEFAULT_BUFF_SIZE, INBOUND, OUTBOUND, BIDIRECTIONAL)
print(_rospy_to_logging_levels[rospy.DEBUG], rosout._rospy_to_logging_levels is _rospy_to_logging_levels)
print(
    issubclass(TCPROSTransport, Transport),
    issubclass(Service, rospy.Service),
    ServiceProxy is rospy.ServiceProxy,
)


class Counted(Transport):
    transport_type = "COUNTED"


counted, closed = Counted(OUTBOUND, "mine"), []
counted.set_cleanup_callback(closed.append)
counted.stat_bytes, counted.local_endpoint, counted.remote_endpoint = 7, ("here", 1), ("there", 2)
print(
    counted.name, counted.direction, counted.done, counted.fileno(), counted.endpoint_id, counted.stat_num_msg
)
counted.close()
dead = DeadTransport(counted)
print(closed == [counted], dead.done, dead.stat_bytes, dead.id == counted.id, dead.get_transport_info())
protocol = TCPROSTransportProtocol("/a", String, queue_size=3)
print(
    protocol.resolved_name,
    protocol.recv_data_class,
    protocol.queue_size,
    protocol.buff_size,
    protocol.direction,
)
print(protocol.get_header_fields())
try:
    non_empty("topic")("", None)
except ParameterInvalid as error:
    print(error, non_empty("topic")("x", None))
for validator in (
    rospy.names.global_name("p"),
    rospy.core.is_topic("p"),
    rospy.core.valid_name("p"),
    rospy.core.valid_name("p", False),
):
    for value in (
        "",
        "/",
        None,
        3,
        "a",
        "a/",
        "/a/",
        "~a",
        "~",
        "/a b",
        "a:b",
        "a//b",
        "ftp://x",
        "+1",
        "\u00e9",
        b"x",
    ):
        try:
            print(value, validator(value, "/ns/me"))
        except ParameterInvalid as error:
            print(value, error)


def buffer_of(*texts, cut=None):
    """A buffer with messages, as a connection has received them."""
    whole = io.BytesIO()
    for text in texts:
        serialize_message(whole, 0, String(text))
    buffer = io.BytesIO()
    buffer.write(whole.getvalue()[:cut])
    return buffer


for texts, cut, options in (
    ([], None, {}),
    (["a", "bb"], None, {}),
    (["a", "bb", "c"], None, {"queue_size": 2}),
    (["a", "bb", "c"], None, {"max_msgs": 1}),
    (["a", "bb", "c"], None, {"start": 9}),
    (["abc", "de"], -1, {}),
    (["abc", "de"], -7, {}),
    (["abc"], 3, {}),
):
    buffer, queue = buffer_of(*texts, cut=cut), [String("old")]
    deserialize_messages(buffer, queue, String, **options)
    print([message.data for message in queue], buffer.tell(), buffer.getvalue())
for buffer in (None, io.BytesIO(b"\x03\0\0\0abc")):
    try:
        if buffer is not None:
            buffer.seek(0, 2)
        deserialize_messages(buffer, [], String)
    except Exception as error:
        print(type(error).__name__, str(error)[:20])

for name in ("ROS_IP", "ROS_HOSTNAME"):
    os.environ.pop(name, None)
print(sorted(network.get_local_addresses()), "127.0.0.1" in network.get_local_addresses())
for host in ("localhost", "127.3.4.5", "no.such.host.invalid", "8.8.8.8", network.get_local_addresses()[-1]):
    print(host, network.is_local_address(host))
for on in ("off", "on"):
    os.environ["ROS_IPV6"] = on
    for address in (None, "", "localhost", "127.0.0.1", "127.0.1.1", "::1", "1.2.3.4", "foo"):
        print(on, address, network.get_bind_address(address))
os.environ["ROS_IPV6"] = "off"
os.environ["ROS_IP"] = "127.0.0.1"
print(network.get_bind_address(), network.get_local_address(), network.create_local_xmlrpc_uri(5))
header = {"topic": "/a", b"md5sum": "*", "x": "1=2\n\u00e4"}
for size in (1, 7, 4096):
    ours, theirs = socket.socketpair()
    print(network.write_ros_handshake_header(ours, header), network.encode_ros_handshake_header(header))
    ours.sendall(b"more")
    ours.close()
    buffer = io.BytesIO()
    fields = network.read_ros_handshake_header(theirs, buffer, size)
    print(sorted(fields.items()), buffer.getvalue()[: buffer.tell()])
for data in (b"\x05\0\0\0\x01\0\0\0a", b"\x7b\0\0\0\x03\0\0\0a=b", b"\x07\0\0\0\x7b\0\0\0a=b"):
    try:
        print(network.decode_ros_handshake_header(data))
    except network.ROSHandshakeException as error:
        print(type(error).__name__)

told = []


class Listener(RegistrationListener):
    def reg_added(self, resolved_name, data_type_or_uri, reg_type):
        told.append(("added", resolved_name, reg_type))

    def reg_removed(self, resolved_name, data_type_or_uri, reg_type):
        told.append(("removed", resolved_name, reg_type))


rospy.init_node("inner", disable_rosout=True)
get_registration_listeners().add_listener(Listener())
publisher, subscriber = rospy.Publisher("a", String, queue_size=1), rospy.Subscriber("b", String)
service = rospy.Service("c", Empty, lambda request: EmptyResponse())
print(get_topic_manager().has_publication("/a"), get_topic_manager().get_subscriptions())
print(
    get_topic_manager().get_impl(Registration.PUB, "/a") is publisher.impl,
    get_service_manager().get_service("/c") is service,
)
proxy = rospy.ServiceProxy("c", Empty)
print(proxy._get_service_uri(Empty._request_class()) == service.uri)
for one in (publisher, subscriber):
    one.unregister()
service.shutdown()
print([row for row in told if row[1] in ("/a", "/b", "/c")])

master = xmlrpcapi(rospy.get_master().getUri()[2])
print(isinstance(master, ServerProxy), master is xmlrpcapi(rospy.get_master().getUri()[2]))
print(master.getParam("/me", "/none")[0], isinstance(rospy.get_master().target, ServerProxy))
print([xmlrpcapi(uri) for uri in (None, "", "localhost:1234", "http://")])
print(isinstance(xmlrpcapi("http://localhost:1", cache=False), ServerProxy))
rospy.set_param("cached", 5)
try:
    get_param_server_cache().get("/cached")
except KeyError as error:
    print("not cached", error)
rospy.get_param_cached("cached")
print(get_param_server_cache().get("/cached"))
for key in ("/none", "/mine"):
    try:
        get_param_server_cache().update(key, 1)
    except KeyError as error:
        print("unknown", error)
    get_param_server_cache().set("/mine", 2)
print(get_param_server_cache().get("/mine"))


class Server:
    lock = __import__("threading").Lock()


class Tracker:
    handle_destruction_time = rospy.Time()


actionlib.handle_tracker_deleter.HandleTrackerDeleter(Server(), Tracker)(None)
print(Tracker.handle_destruction_time > rospy.Time())
