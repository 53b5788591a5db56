"""A small process beside a program that drives: it stops the robot when the program is gone without a word.

Most robots go on with the last velocity or goal when the program that gave it is killed. `Watchdog` starts a
process of its own, tells it through a pipe what is to be sent then (zero on velocity topics, the cancel of a
goal, a call of a service), and shows every tenth of a second that the program is alive while something moves.
When the pipe ends, or nothing came for 0.8 s, the process sends what it was told. It sends nothing else.

`protocol` has the lines of the pipe and decides what is due (pure), `watchdog` is the program's side,
`process` is the process.
"""

from rosproto.watchdog.protocol import LastCall, LastMessage, WatchedNode, is_watchdog_name
from rosproto.watchdog.watchdog import Watch, Watchdog, watched_node_of

__all__ = [
    "LastCall",
    "LastMessage",
    "Watch",
    "Watchdog",
    "WatchedNode",
    "is_watchdog_name",
    "watched_node_of",
]
