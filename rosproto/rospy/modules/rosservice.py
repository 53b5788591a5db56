"""rosservice's functions for programs: names, types and calls of services."""

import time

import rosgraph
import rospy
from genpy.message import fill_message_args, get_printable_message_args, get_service_class
from std_msgs.msg import Header

from rosproto.errors import RosError
from rosproto.node.services.probe import probe
from rosproto.rospy.host import Caller
from rosproto.transport.deadline import Deadline


class ROSServiceException(Exception):
    """A service cannot be used."""


class ROSServiceIOException(ROSServiceException):
    """The master or the provider cannot be reached."""


def _services():
    try:
        return rosgraph.Master("/rosservice").getSystemState()[2]
    except OSError:
        raise ROSServiceIOException("Unable to communicate with master!") from None


def get_service_list(node=None, namespace=None, include_nodes=False):
    """Names of all services, of a node's services, or of the services in a namespace."""
    found = [
        (name, nodes)
        for name, nodes in _services()
        if (node is None or node in nodes)
        and (not namespace or name.startswith(rosgraph.names.make_global_ns(namespace)))
    ]
    return found if include_nodes else [name for name, _ in found]


def get_service_node(service_name):
    """Name of the node that provides the service; None if there is none."""
    return next((nodes[0] for name, nodes in _services() if name == service_name), None)


def get_service_headers(service_name, service_uri=None):
    """The provider's connection header."""
    try:
        return probe(Caller("/rosservice", rosgraph.get_master_uri()), service_name, Deadline(5.0))
    except RosError as error:
        raise ROSServiceIOException("Unable to communicate with service [%s]" % service_name) from error


def get_service_uri(service_name):
    """rosrpc://host:port of the service's provider; None if there is none."""
    try:
        return rosgraph.Master("/rosservice").lookupService(service_name)
    except rosgraph.MasterException:
        return None
    except OSError:
        raise ROSServiceIOException("Unable to communicate with master!") from None


def get_service_args(service_name):
    """Names of the request's fields, separated by spaces."""
    return get_printable_message_args(get_service_class_by_name(service_name)._request_class())


def rosservice_find(service_type):
    """Names of the services of a type."""
    return [name for name in get_service_list() if get_service_type(name) == service_type]


def get_service_type(service_name):
    """Type of the service; None if it has no provider."""
    if get_service_node(service_name) is None:
        return None
    return get_service_headers(service_name).get("type")


def get_service_class_by_name(service_name):
    """Class of the service.

    Raises:
        ROSServiceException: The service or its type is unknown.
    """
    type_ = get_service_type(service_name)
    if type_ is None:
        raise ROSServiceException("Service [%s] is not available." % service_name)
    found = get_service_class(type_)
    if found is None:
        raise ROSServiceException("Unable to load type [%s]." % type_)
    return found


def call_service(service_name, service_args, service_class=None):
    """Call a service with a list of values, or a list of one dict; return (request, response)."""
    service_class = service_class or get_service_class_by_name(service_name)
    request = service_class._request_class()
    now = rospy.get_rostime() if rospy.core.is_initialized() else rospy.Time.from_sec(time.time())
    fill_message_args(request, service_args, {"now": now, "auto": Header(stamp=now)})
    try:
        return request, rospy.ServiceProxy(service_name, service_class)(request)
    except rospy.ServiceException as error:
        raise ROSServiceException(str(error)) from error
