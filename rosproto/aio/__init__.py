"""The asyncio API: the same nodes, publishers, subscribers, services, actions and parameters, awaited.

    async with aio.Node("/laptop", master_uri="http://10.0.0.7:11311") as node:
        async with node.subscriber("/odom", "nav_msgs/Odometry") as odom:
            async for message in odom: ...

Threads do the receiving, which is faster than asyncio's; the loop is woken once for everything that has
arrived. Import it with `from rosproto import aio`: `import rosproto` does not load it, since asyncio takes
longer to import than all of rosproto.
"""

from rosproto.aio.actions import ActionClient, ActionServer, GoalHandle
from rosproto.aio.mailbox import Mailbox
from rosproto.aio.node import Node, view
from rosproto.aio.parameters import Parameters, ParameterSubscription
from rosproto.aio.pool import Pool, notify
from rosproto.aio.read_budget import BudgetedProtocol, ReadBudget
from rosproto.aio.same_property import SameProperty
from rosproto.aio.services import ServiceClient, ServiceServer
from rosproto.aio.topics import Publisher, Subscriber

__all__ = [
    "ActionClient",
    "ActionServer",
    "BudgetedProtocol",
    "GoalHandle",
    "Mailbox",
    "Node",
    "ParameterSubscription",
    "Parameters",
    "Pool",
    "Publisher",
    "ReadBudget",
    "SameProperty",
    "ServiceClient",
    "ServiceServer",
    "Subscriber",
    "notify",
    "view",
]
