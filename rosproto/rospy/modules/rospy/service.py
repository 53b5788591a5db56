"""rospy.service: ServiceException and ServiceManager."""

from .core import *  # rospy's module has these names, too, and programs import them from here


class ServiceException(Exception):
    """A service call failed; raised by a handler, it rejects the request."""


class ServiceManager:
    """The services this node provides, by resolved name."""

    def __init__(self):
        self.map = {}

    def get_services(self):
        """[(name, uri), ...]."""
        return [(name, service.uri) for name, service in list(self.map.items())]

    def get_service(self, resolved_service_name):
        """The service of that name; None if there is none."""
        return self.map.get(resolved_service_name)


manager = ServiceManager()
