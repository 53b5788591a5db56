"""genmsg.srvs: a service as SrvSpec."""

from .msgs import Equal
from .names import package_resource_name


class SrvSpec(Equal):
    """A service: `request` and `response` are MsgSpec."""

    def __init__(self, request, response, text, full_name="", short_name="", package=""):
        own_package, own_name = package_resource_name(full_name)
        self.request, self.response, self.text, self.full_name = request, response, text, full_name
        self.package, self.short_name = package or own_package, short_name or own_name

    def __repr__(self):
        return "SrvSpec[%r, %r]" % (self.request, self.response)
