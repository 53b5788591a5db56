"""rospy's exceptions for failed service calls."""

from rosproto.errors import ConnectionLost, MasterError, Md5sumMismatch, RosTimeout, ServiceError

from .. import core, names
from ..service import ServiceException


def service_exception(service, error):
    """The ServiceException that rospy raises for what went wrong in a call of that service."""
    if core.is_shutdown():  # what rospy raises then (measured), though its documentation names another
        return ServiceException("service [%s] returned no response" % service)
    if isinstance(error, Md5sumMismatch):
        who, asked, theirs = names.get_caller_id(), error.md5sum, error.remote_md5sum
        return ServiceException(
            "unable to connect to service: remote error reported: "
            "request from [%s]: md5sums do not match: [%s] vs. [%s]" % (who, asked, theirs)
        )
    cause = error.__cause__
    if isinstance(error, ServiceError):
        if isinstance(cause, MasterError):
            return ServiceException("service [%s] unavailable" % service)
        if type(error) is not ServiceError:  # refused in the handshake
            return ServiceException("unable to connect to service: remote error reported: %s" % error.text)
        data = error.text.encode("utf-8", "surrogateescape")
        return ServiceException("service [%s] responded with an error: %s" % (service, data))
    if isinstance(error, (ConnectionLost, RosTimeout)) and isinstance(cause, OSError):
        return ServiceException("unable to connect to service: %s" % cause)
    if isinstance(error, ConnectionLost):
        return ServiceException(
            "transport error completing service call: unable to receive data from sender,"
            " check sender's logs for details"
        )
    return ServiceException("unable to connect to service: %s" % error)
