"""rospy.impl.tcpros: the names that programs import from it."""

from . import _unserved
from .tcpros_base import DEFAULT_BUFF_SIZE

__all__ = ["DEFAULT_BUFF_SIZE", "get_tcpros_handler", "init_tcpros"]

init_tcpros = _unserved.function("rospy.impl.tcpros.init_tcpros")
get_tcpros_handler = _unserved.function("rospy.impl.tcpros.get_tcpros_handler")
