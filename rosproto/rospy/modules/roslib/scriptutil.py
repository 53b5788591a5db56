"""roslib.scriptutil: the master for scripts, under its old names."""

from rosgraph.names import script_resolve_name
from rosgraph.rosenv import get_master_uri
from rospy.core import xmlrpcapi


def get_master():
    """An XML-RPC proxy of the master."""
    return xmlrpcapi(get_master_uri())


get_param_server = get_master
