"""/rosapi inside the gateway: the graph, types and parameters for web clients.

`Rosapi` answers calls with JSON values; `provide` registers the same services in ROS.
"""

from rosproto.gateway.rosbridge.rosapi.answers import ProvidedRosapi, Rosapi, provide
from rosproto.gateway.rosbridge.rosapi.graph import RosapiError

__all__ = ["ProvidedRosapi", "Rosapi", "RosapiError", "provide"]
