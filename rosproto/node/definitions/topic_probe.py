"""Ask a publisher for the type, md5sum and definition of its topic, without receiving a message.

As rostopic does, we connect with the wildcard md5sum, read the publisher's header and close. We do not
register at the master.

Source: wiki.ros.org/ROS/TCPROS, wiki.ros.org/ROS/Slave_API (requestTopic).
"""

from __future__ import annotations

import socket

from rosproto.errors import ConnectionLost
from rosproto.node.definitions.topic_type import ANY
from rosproto.node.graph.master_client import CallerIdentity
from rosproto.node.graph.slave_client import NodeClient
from rosproto.protocol.handshake import PublisherReply, check_publisher_header, subscriber_header
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import connect, read_header, write_header


def probe_topic(caller: CallerIdentity, topic: str, publisher: str, deadline: Deadline) -> PublisherReply:
    """The header that one publisher sends for a topic.

    Args:
        caller: Identity of the calling node.
        topic: Resolved name.
        publisher: Name of the publishing node.
        deadline: For all steps together.

    Raises:
        MasterError: The master does not know the node, or it does not publish the topic (any more).
        ConnectionLost, RosTimeout: It cannot be reached.
        RemoteProtocolError: Its answer is not a publisher's header.
    """
    uri = caller.master.lookup_node(publisher, timeout=deadline.remaining())
    sock = connect(*address_of(caller, topic, uri, deadline), deadline, hosts=caller.hosts)
    try:
        callerid = additional_callerid(caller, sock)
        wanted = subscriber_header(topic=topic, type_name=ANY, md5sum=ANY, callerid=callerid)
        write_header(sock, wanted, deadline)
        header = read_header(sock, caller.limits, deadline)
    finally:
        sock.close()
    return check_publisher_header(header, topic=topic, type_name=ANY, md5sum=ANY, peer=publisher)


def additional_callerid(caller: CallerIdentity, sock: socket.socket) -> str:
    """Name for a connection beside a subscriber's: rospy ends the older one of two with the same callerid
    (`add_connection` in rospy/topics.py).
    """
    return f"{caller.name}_{sock.getsockname()[1]}"


def address_of(caller: CallerIdentity, topic: str, uri: str, deadline: Deadline) -> tuple[str, int]:
    """Host and port where the node with that XML-RPC URI sends a topic.

    Raises:
        MasterError: It does not publish the topic (any more).
        ConnectionLost, RosTimeout: It cannot be reached, or offers no TCPROS connection.
    """
    with NodeClient(uri, caller.name, limits=caller.limits, hosts=caller.hosts) as peer:
        answer = peer.request_topic(topic, timeout=deadline.remaining())
    if len(answer) < 3 or answer[0] != "TCPROS" or not isinstance(answer[2], int):
        raise ConnectionLost(
            f"{topic}: {uri} offers no TCPROS connection (answered {str(answer)[:100]})", peer=uri
        )
    return str(answer[1]), answer[2]
