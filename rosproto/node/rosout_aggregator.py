"""The node /rosout of roscore: what all nodes say on /rosout, again on /rosout_agg.

A tool that wants the log of the whole graph (rqt_console, rosbag record, `rostopic echo /rosout_agg`)
subscribes one topic of one node instead of one of each. Messages are passed on as they came, not decoded.

Source: wiki.ros.org/rosout; ros_comm tools/rosout/rosout.cpp. Debian's also writes a file, rosout.log: a bag,
or `rosproto topic echo /rosout_agg`, is there for that.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rosproto.node.loggers import Loggers
from rosproto.node.node import Node

__all__ = ["RosoutAggregator"]

LOG = "rosgraph_msgs/Log"
QUEUE = 1000  # messages; a start of many nodes is a burst


class RosoutAggregator:
    """Serves from construction on until `close()`; usable in a `with`.

    Args:
        master_uri: The master.
        host: Address or name under which others reach this computer; None: the one that routes to the master.
        allow: Addresses that may connect; None for all.

    Raises:
        ConnectionLost, RosTimeout: No master answers.

    Attributes:
        node: The node /rosout, with ~get_loggers and ~set_logger_level.
    """

    def __init__(
        self, master_uri: str, *, host: str | None = None, allow: Iterable[str] | None = None
    ) -> None:
        self.node = Node("/rosout", master_uri=master_uri, host=host, rosout=False, allow=allow)
        try:
            Loggers(self.node)
            self._out = self.node.publisher("/rosout_agg", LOG, queue_size=QUEUE)
            self.node.subscriber("/rosout", LOG, self._pass_on, raw=True, queue_size=QUEUE)
        except BaseException:
            self.node.close()
            raise

    def __enter__(self) -> RosoutAggregator:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<RosoutAggregator {self.node!r}>"

    def close(self) -> None:
        """Take the node off the master. May be called again."""
        self.node.close()

    def _pass_on(self, message: Any) -> None:
        if not self.node.closed:
            self._out.publish(message)
