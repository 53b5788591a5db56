"""ROS 1 in pure Python: nodes, a master, messages, actions, bags. Independent of any robot (see
`woosh_pure`).

    import rosproto
    with rosproto.Node("/laptop", master_uri="http://10.0.0.7:11311") as node:
        for scan in node.subscriber("/scan", "sensor_msgs/LaserScan"):
            print(min(scan.ranges))

Nodes, bags, the master and the codec are imported on first use (PEP 562): a program that reads a bag does not
load the network code.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from rosproto.errors import (
    BagError,
    CodecError,
    ConnectionLost,
    DefinitionError,
    LocalProtocolError,
    MasterError,
    Md5sumMismatch,
    ProtocolError,
    RegistrationsRefused,
    RemoteProtocolError,
    RosError,
    RosTimeout,
    ServiceError,
    TooLarge,
)
from rosproto.protocol.wire_limits import Limits
from rosproto.time import Duration, Time
from rosproto.version import __version__ as __version__

if TYPE_CHECKING:
    from rosproto.action import ActionClient, ActionServer, GoalStatus
    from rosproto.bag import BagReader, BagWriter
    from rosproto.codec import (
        AnyMsg,
        Message,
        ServiceType,
        decode,
        define,
        encode,
        message_class,
        service_class,
    )
    from rosproto.master import Master
    from rosproto.node import (
        Event,
        EventKind,
        MasterClient,
        Node,
        NodeClient,
        Publisher,
        ServiceClient,
        ServiceServer,
        Subscriber,
    )

__all__ = [
    "ActionClient",
    "ActionServer",
    "AnyMsg",
    "BagError",
    "BagReader",
    "BagWriter",
    "CodecError",
    "ConnectionLost",
    "DefinitionError",
    "Duration",
    "Event",
    "EventKind",
    "GoalStatus",
    "Limits",
    "LocalProtocolError",
    "Master",
    "MasterClient",
    "MasterError",
    "Md5sumMismatch",
    "Message",
    "Node",
    "NodeClient",
    "ProtocolError",
    "Publisher",
    "RegistrationsRefused",
    "RemoteProtocolError",
    "RosError",
    "RosTimeout",
    "ServiceClient",
    "ServiceError",
    "ServiceServer",
    "ServiceType",
    "Subscriber",
    "Time",
    "TooLarge",
    "decode",
    "define",
    "encode",
    "message_class",
    "service_class",
]

_HOME = {
    "rosproto.action": "ActionClient ActionServer GoalStatus",
    "rosproto.bag": "BagReader BagWriter",
    "rosproto.codec": "AnyMsg Message ServiceType decode define encode message_class service_class",
    "rosproto.master": "Master",
    "rosproto.node": "Event EventKind MasterClient Node NodeClient Publisher ServiceClient ServiceServer "
    "Subscriber",
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names.split()}
_SUBMODULES = "action aio bag codec errors gateway master msg names node recording tf".split()


def __getattr__(name: str) -> object:
    """Import a name or a subpackage on first use (PEP 562)."""
    module = _MODULE_OF.get(name) or (f"{__name__}.{name}" if name in _SUBMODULES else None)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        found = import_module(module)
    except OSError as error:  # the process is out of files, so no module can be opened
        raise RosError(f"{__name__}.{name} cannot be loaded: {error}") from error
    value: object = getattr(found, name) if name in _MODULE_OF else found
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_SUBMODULES})
