"""/rosapi, answered inside the gateway: what a web client asks about the graph, its types and parameters.

`Rosapi` answers calls as JSON has them; `provide` registers the same answers as ROS services.
"""

from rosproto.gateway.rosbridge.rosapi.answers import Rosapi, RosapiError
from rosproto.gateway.rosbridge.rosapi.provided import ProvidedRosapi, provide

__all__ = ["ProvidedRosapi", "Rosapi", "RosapiError", "provide"]
