"""Messages that a publisher sends after a certain moment: through a connection that is made then.

A message may arrive long after it was sent, through a slow network or a full queue, and its arrival does not
show it. Through a new connection a publisher sends only what it publishes after it has accepted the
connection, in roscpp, rospy and here (wiki.ros.org/ROS/TCPROS), except for a latched message. So nothing that
comes is older than the call, and no clocks are compared.
"""

from __future__ import annotations

from collections.abc import Generator

from rosproto.codec import Message, decode
from rosproto.errors import RosError
from rosproto.node.definitions.topic_probe import additional_callerid, address_of
from rosproto.node.graph.master_client import CallerIdentity
from rosproto.node.incoming.tcpros_link import FrameReader
from rosproto.protocol.framing import BytesLike
from rosproto.protocol.handshake import check_publisher_header, subscriber_header
from rosproto.transport.deadline import Deadline
from rosproto.transport.os_errors import translate
from rosproto.transport.tcp import connect, read_header, write_header
from rosproto.transport.uri import parse_uri


def fresh_messages(
    caller: CallerIdentity, topic: str, message_class: type[Message], address: str, deadline: Deadline
) -> Generator[Message, None, None]:
    """Connect to a publisher, and yield what it publishes from now on. Ends when the deadline has passed.

    Needs no thread, no answer of the master, and no lock. Close the iterator to disconnect.

    Args:
        caller: Our node.
        topic: Resolved name.
        message_class: The class of the messages.
        address: Where the publisher is: `LinkStats.address` of a connected link, or its XML-RPC URI.
        deadline: For all of it.

    Raises:
        ConnectionLost: The publisher cannot be reached, or has closed the connection.
        MasterError: It does not publish the topic (any more).
        Md5sumMismatch, HandshakeRefused: It publishes messages of another definition.
        RemoteProtocolError: Its answer is not a publisher's header.
        ValueError: `address` is not an address.
    """
    type_name, md5sum = message_class._type, message_class._md5sum

    def decoded(buffer: BytesLike, start: int, end: int) -> Message:
        return decode(message_class, bytes(buffer[start:end]))

    try:
        is_uri = "://" in address  # as the address of a link inside this process is
        place = address_of(caller, topic, address, deadline) if is_uri else parse_uri(address)
        sock = connect(*place, deadline, hosts=caller.hosts)
        try:
            wanted = subscriber_header(
                topic=topic,
                type_name=type_name,
                md5sum=md5sum,
                callerid=additional_callerid(caller, sock),
                message_definition=message_class._full_text,
            )
            write_header(sock, wanted, deadline)
            header = read_header(sock, caller.limits, deadline)
            check_publisher_header(header, topic=topic, type_name=type_name, md5sum=md5sum, peer=address)
            reader = FrameReader(sock, caller.limits.message_bytes, peer=address)
            is_old = header.get("latching") == "1"
            while left := deadline.remaining():
                sock.settimeout(left)
                batch = reader.receive(decoded, False)
                yield from batch[1:] if is_old else batch
                is_old = False
        finally:
            sock.close()
    except TimeoutError:
        return
    except RosError:
        raise
    except OSError as error:
        raise translate(error, f"{topic} from {address}", address) from error
