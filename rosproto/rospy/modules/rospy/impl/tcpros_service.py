"""rospy.impl.tcpros_service: Service, ServiceProxy, wait_for_service, and rospy's exceptions for failed
calls."""

import logging
import sys
import threading
import time
import traceback
from functools import cache

import genpy
import rosgraph
from genpy.message import encode_message, sendable

from rosproto.errors import ConnectionLost, MasterError, Md5sumMismatch, RosError, RosTimeout, ServiceError
from rosproto.names import is_usable_name
from rosproto.node.options import host_names
from rosproto.node.services.client import ServiceClient
from rosproto.protocol.handshake import service_client_header
from rosproto.rospy.host import Caller, refusal
from rosproto.rospy.messages import Encoded, is_ours, node_service
from rosproto.transport.deadline import Deadline
from rosproto.transport.robot_host_names import HostNames
from rosproto.transport.tcp import connect, write_header

from .. import core, names
from ..exceptions import ROSException, ROSInterruptException
from ..msg import args_kwds_to_message
from ..rostime import Duration, wallsleep
from ..service import ServiceException, manager
from ._unserved import Unserved
from .registration import Registration, get_registration_listeners


def _why(service, error):
    """The text of rospy's ServiceException for an error in a call of that service."""
    if core.is_shutdown():  # what rospy raises then (measured), though its documentation names another
        return "service [%s] returned no response" % service
    if isinstance(error, Md5sumMismatch):
        who, asked, theirs = names.get_caller_id(), error.md5sum, error.remote_md5sum
        return (
            "unable to connect to service: remote error reported: "
            "request from [%s]: md5sums do not match: [%s] vs. [%s]" % (who, asked, theirs)
        )
    cause = error.__cause__
    if isinstance(error, ServiceError):
        if isinstance(cause, MasterError):
            return "service [%s] unavailable" % service
        if type(error) is not ServiceError:  # refused in the handshake
            return "unable to connect to service: remote error reported: %s" % error.text
        data = error.text.encode("utf-8", "surrogateescape")
        return "service [%s] responded with an error: %s" % (service, data)
    if isinstance(error, (ConnectionLost, RosTimeout)) and isinstance(cause, OSError):
        return "unable to connect to service: %s" % cause
    if isinstance(error, ConnectionLost):
        return (
            "transport error completing service call: unable to receive data from sender,"
            " check sender's logs for details"
        )
    return "unable to connect to service: %s" % error


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
    end = time.monotonic() + timeout if timeout else None
    failed = False
    while not core.is_shutdown() and (end is None or time.monotonic() < end):
        try:
            uri = _contact(master, resolved, 10.0 if end is None else max(0.05, end - time.monotonic()))
            if uri:
                if failed:
                    core.loginfo("wait_for_service(%s): finally were able to contact [%s]" % (resolved, uri))
                return
        except Exception:
            failed = True
            core.logwarn_throttle(10, "wait_for_service(%s): failed to contact, will keep trying" % resolved)
        time.sleep(PAUSE)
    if core.is_shutdown():
        raise ROSInterruptException("rospy shutdown")
    raise ROSException("timeout exceeded while waiting for service %s" % resolved)


def _contact(master, resolved, timeout):
    """URI of a provider that answers, None when there is none."""
    try:
        uri = master.lookupService(resolved)
    except rosgraph.MasterException:
        return None
    deadline = Deadline(timeout)
    fields = service_client_header(service=resolved, md5sum="*", callerid=names.get_caller_id(), probe=True)
    with connect(*core.parse_rosrpc_uri(uri), deadline, hosts=HostNames(host_names())) as sock:
        write_header(sock, fields, deadline)
    return uri


logger = logging.getLogger("rospy.service")
DEFAULT_BUFF_SIZE = 65536

_node = None
_lock = threading.RLock()


def attach(node):
    """Use the node, and provide the services made before it existed."""
    global _node
    with _lock:
        _node = node
        for service in list(manager.map.values()):
            service._open(node)


_caller_before_node = cache(Caller)


def _caller_now():
    """The caller of services: the node, or before there is one a stand-in for the current environment."""
    if _node is not None:
        return _node
    return _caller_before_node(names.get_caller_id(), rosgraph.get_master_uri())


# -- calling ------------------------------------------------------------------------------------------------


def _for_node(message):
    """A request or response for the node; one of our classes as it is, so that its revision can be converted.

    Raises:
        genpy.SerializationError: A value does not fit its field.
    """
    if is_ours(type(message)):
        return sendable(message)
    return Encoded(message._type, encode_message(message))


class _Service:
    def __init__(self, name, service_class):
        self.resolved_name = names.resolve_name(name)
        self.service_class = service_class
        self.request_class = service_class._request_class
        self.response_class = service_class._response_class
        self.uri = None


class ServiceProxy(_Service):
    """Calls a service: `proxy(request)`, `proxy(1, 2)`, `proxy(a=1, b=2)`, or `.call(...)`."""

    def __init__(self, name, service_class, persistent=False, headers=None):
        super().__init__(name, service_class)
        self.persistent = persistent
        self._headers = headers or {}
        self._client = None
        self._client_of = None

    def wait_for_service(self, timeout=None):
        """Wait until the service is provided."""
        wait_for_service(self.resolved_name, timeout=timeout)

    def __call__(self, *args, **kwds):
        """As `call`."""
        return self.call(*args, **kwds)

    def call(self, *args, **kwds):
        """Call the service.

        Raises:
            ServiceException: There is no provider, it failed, or the node was shut down meanwhile.
            genpy.SerializationError: A value does not fit its field.
        """
        request = args_kwds_to_message(self.request_class, args, kwds)
        if not isinstance(request, genpy.Message):
            raise TypeError("request object is not a valid request message instance")
        if self.request_class._type != request._type:
            raise TypeError(
                "request object type [%s] does not match service type [%s]"
                % (request.__class__, self.request_class)
            )
        try:
            client = self._opened()
            response = client.call(self._sent(request), timeout=None)
            if client.address is not None:
                self.uri = "%s%s:%s" % (core.ROSRPC, *client.address)
            return response
        except RosError as error:
            raise ServiceException(_why(self.resolved_name, error)) from error
        except OSError as error:
            raise ServiceException("unable to contact master") from error

    def _get_service_uri(self, request=None):
        """Look up the service.

        Raises:
            ServiceException: There is no provider, or the master is unreachable.
        """
        try:
            self.uri = rosgraph.Master(names.get_caller_id()).lookupService(self.resolved_name)
        except OSError:
            raise ServiceException("unable to contact master") from None
        except rosgraph.MasterException:
            raise ServiceException("service [%s] unavailable" % self.resolved_name) from None
        return self.uri

    def _opened(self):
        if not is_usable_name(self.resolved_name):
            raise ServiceException("service [%s] unavailable" % self.resolved_name)
        caller = _caller_now()
        client = self._client
        if client is None or self._client_of is not caller:
            service = node_service(self.service_class)
            if caller is _node:
                client = caller.service_client(self.resolved_name, service, persistent=self.persistent)
            else:
                client = ServiceClient(
                    caller, self.resolved_name, service, persistent=self.persistent, on_close=lambda _: None
                )
            client.add_headers({str(key): str(value) for key, value in self._headers.items()})
            self._client, self._client_of = client, caller
        return client

    def _sent(self, request):
        """The request for the node.

        Raises:
            genpy.SerializationError: A value does not fit; but a missing provider is reported first.
        """
        if getattr(request, "_has_header", False) and request.header.frame_id is None:
            request.header.frame_id = "0"
        try:
            return _for_node(request)
        except (genpy.SerializationError, AttributeError):
            self._get_service_uri()
            raise

    def close(self):
        """Close the connection of a persistent proxy."""
        if self._client is not None:
            self._client.close()
            self._client = None


# -- providing ----------------------------------------------------------------------------------------------


def convert_return_to_response(response, response_class):
    """Convert a handler's return value to a response.

    Raises:
        ServiceException: It is not a response, or values are missing.
    """
    if isinstance(response, genpy.Message) and response._type == response_class._type:
        return response
    if type(response) is dict:
        try:
            return response_class(**response)
        except AttributeError as error:
            raise ServiceException("handler returned invalid value: %s" % str(error)) from None
    if response is None:
        raise ServiceException("service handler returned None")
    if type(response) in (list, tuple):
        try:
            return response_class(*response)
        except TypeError as error:
            raise ServiceException("handler returned wrong number of values: %s" % str(error)) from None
    try:
        return response_class(response)
    except TypeError as error:
        raise ServiceException("handler returned invalid value: %s" % str(error)) from None


class Service(_Service):
    """Provides a service: `handler(request)` returns the response, a dict, a list, or a bare value."""

    def __init__(self, name, service_class, handler, buff_size=DEFAULT_BUFF_SIZE, error_handler=None):
        super().__init__(name, service_class)
        if not name or not isinstance(name, str):
            raise ValueError("service name is not a non-empty string")
        names.warn_if_illegal(name, stacklevel=2)
        self.handler = handler
        self.done = False
        self._server = None
        if error_handler is not None:
            self.error_handler = error_handler
        with core.uninterrupted, _lock:
            if self.resolved_name in manager.map:
                raise ServiceException("service [%s] already registered" % self.resolved_name)
            if _node is not None:
                self._open(_node)
            manager.map[self.resolved_name] = self
        get_registration_listeners().notify_added(self.resolved_name, self.uri, Registration.SRV)

    def _open(self, node):
        if not is_usable_name(self.resolved_name):
            text = "ERROR: parameter [service] contains illegal chars"
            core.logfatal("unable to register service [%s] with master: %s" % (self.resolved_name, text))
            return
        self._server = node.service_server(self.resolved_name, node_service(self.service_class), self._answer)
        self.uri = node.rosrpc_uri

        def refused(fields, error):
            if isinstance(error, Md5sumMismatch):
                node.on_refused(refusal(fields, error))

        self._server.on_refused = refused

    def error_handler(self, e, exc_type, exc_value, tb):
        """Called when the handler raised."""
        core.logerr(
            "Error processing request: %s\n%s" % (e, traceback.format_exception(exc_type, exc_value, tb))
        )

    def _answer(self, request):
        try:
            return _for_node(convert_return_to_response(self.handler(request), self.response_class))
        except ServiceException as error:
            core.rospydebug("handler raised ServiceException: %s", error)
            raise ServiceError(self.resolved_name, "service cannot process request: %s" % error) from None
        except Exception as error:
            self.error_handler(error, *sys.exc_info())
            raise ServiceError(self.resolved_name, "error processing request: %s" % error) from None

    def handle(self, transport, header):
        """What rospy's own connection calls; there is none here."""
        raise Unserved("rospy.Service.handle")

    def shutdown(self, reason=""):
        """Stop providing the service; running calls are still answered. The handler may call this."""
        self.done = True
        with core.uninterrupted:
            with _lock:
                known = manager.map.get(self.resolved_name) is self
                if known:
                    del manager.map[self.resolved_name]
            if self._server is not None:
                self._server.leave()
        if known:
            get_registration_listeners().notify_removed(self.resolved_name, self.uri, Registration.SRV)

    def spin(self):
        """Wait until the service or the node is shut down."""
        try:
            while not core.is_shutdown() and not self.done:
                wallsleep(0.1)
        except KeyboardInterrupt:
            core.logdebug("keyboard interrupt, shutting down")


ServiceImpl = Service  # rospy's name for the base of a Service and of its relay
