"""wait_for_service."""

import time

import rosgraph

from .. import core, names
from ..exceptions import ROSException, ROSInterruptException
from ..rostime import Duration

PAUSE = 0.1  # seconds between checks for a service (rospy: 0.3)


def wait_for_service(service, timeout=None):
    """Wait until a service is provided and its provider can be reached.

    Raises:
        ROSException: It was not in time.
        ROSInterruptException: The node was shut down meanwhile.
    """
    if isinstance(timeout, Duration):
        timeout = timeout.to_sec()
    if timeout == 0.0:
        raise ValueError("timeout must be non-zero")
    resolved = names.resolve_name(service)
    master = rosgraph.Master(names.get_caller_id())
    end = time.time() + timeout if timeout else None
    failed = False
    while not core.is_shutdown() and (end is None or time.time() < end):
        try:
            uri = _contact(master, resolved, 10.0 if end is None else max(0.05, end - time.time()))
            if uri:
                if failed:
                    core.loginfo("wait_for_service(%s): finally were able to contact [%s]" % (resolved, uri))
                return
        except KeyboardInterrupt:
            raise
        except Exception:
            failed = True
            core.logwarn_throttle(10, "wait_for_service(%s): failed to contact, will keep trying" % resolved)
        time.sleep(PAUSE)
    if core.is_shutdown():
        raise ROSInterruptException("rospy shutdown")
    raise ROSException("timeout exceeded while waiting for service %s" % resolved)


def _contact(master, resolved, timeout):
    """URI of a provider that answers, None when there is none."""
    from rosproto.node.options import host_names
    from rosproto.protocol.handshake import service_client_header
    from rosproto.transport.connecting import connect
    from rosproto.transport.deadline import Deadline
    from rosproto.transport.host_names import HostNames
    from rosproto.transport.tcpros_io import write_header

    try:
        uri = master.lookupService(resolved)
    except rosgraph.MasterException:
        return None
    deadline = Deadline(timeout)
    sock = connect(*core.parse_rosrpc_uri(uri), deadline, hosts=HostNames(host_names()))
    try:
        fields = service_client_header(
            service=resolved, md5sum="*", callerid=names.get_caller_id(), probe=True
        )
        write_header(sock, fields, deadline)
    finally:
        sock.close()
    return uri
