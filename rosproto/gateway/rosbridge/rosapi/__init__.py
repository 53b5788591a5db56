"""/rosapi inside the gateway: answers to web clients' questions about the graph, its types and parameters.

`Rosapi` answers calls with JSON values; `provide` registers the same answers as ROS services.
"""

from rosproto.gateway.rosbridge.rosapi.answers import ProvidedRosapi, Rosapi, provide
from rosproto.gateway.rosbridge.rosapi.graph import RosapiError

__all__ = ["ProvidedRosapi", "Rosapi", "RosapiError", "provide"]
