"""rospy.impl.tcpros: the names that programs import from it."""

from ._unserved import unserved
from .tcpros_base import DEFAULT_BUFF_SIZE

init_tcpros = unserved("rospy.impl.tcpros.init_tcpros")
get_tcpros_handler = unserved("rospy.impl.tcpros.get_tcpros_handler")
