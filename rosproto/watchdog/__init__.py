"""A watchdog process beside a program that drives: it stops the robot when the program dies or hangs.

Most robots continue with the last velocity or goal when the program that sent it is killed. `Watchdog` starts
a separate process and tells it through a pipe what to send in that case (zero on velocity topics, the cancel
of a goal, a call of a service, a request over HTTP). While something moves it also sends a heartbeat every
tenth of a second. When the pipe ends, or no heartbeat came for 0.8 s, the process sends these messages, and
nothing else.

`protocol` has the messages on the pipe and decides what is due (pure), `watchdog` is the program's side,
`process` is the process.
"""

from rosproto.deprecation import former_names
from rosproto.watchdog.protocol import (
    ROUNDS,
    LastCall,
    LastMessage,
    LastRequest,
    WatchedNode,
    is_watchdog_name,
)
from rosproto.watchdog.watchdog import Watch, Watchdog, watched_node_of

__all__ = [
    "ROUNDS",
    "LastCall",
    "LastMessage",
    "LastRequest",
    "Watch",
    "Watchdog",
    "WatchedNode",
    "is_watchdog_name",
    "watched_node_of",
]

__getattr__ = former_names(__name__, {"Place": "WatchedNode", "place_beside": "watched_node_of"})
