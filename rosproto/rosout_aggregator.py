"""The node /rosout of roscore: what all nodes say on /rosout, again on /rosout_agg.

A tool that wants the log of the whole graph (rqt_console, rosbag record, `rostopic echo /rosout_agg`)
subscribes one topic of one node instead of one of each. Messages are passed on as they came, not decoded.

Source: wiki.ros.org/rosout; ros_comm tools/rosout/rosout.cpp. Debian's always writes a file, too; ours when
it is given one (`rosout_log`).
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

from rosproto.codec import decode, message_class
from rosproto.errors import CodecError
from rosproto.logs import get_logger
from rosproto.node.node import Node
from rosproto.node.rosout.log_file import RosoutLog
from rosproto.node.rosout.loggers import Loggers

__all__ = ["RosoutAggregator"]

_logger = get_logger("rosproto.node")

LOG = "rosgraph_msgs/Log"
QUEUE = 1000  # messages; a start of many nodes is a burst


class RosoutAggregator:
    """Serves from construction on until `close()`; usable in a `with`.

    Args:
        master_uri: The master.
        host: Address or name under which others reach this computer; None: the one that routes to the master.
        allow: Addresses that may connect; None for all.
        log_file: A file that gets a line for each record, as Debian's rosout.log; None writes none.

    Raises:
        ConnectionLost, RosTimeout: No master answers.
        OSError: The file cannot be opened.

    Attributes:
        node: The node /rosout, with ~get_loggers and ~set_logger_level.
    """

    def __init__(
        self,
        master_uri: str,
        *,
        host: str | None = None,
        allow: Iterable[str] | None = None,
        log_file: str | os.PathLike[str] | None = None,
    ) -> None:
        self.node = Node("/rosout", master_uri=master_uri, host=host, rosout=False, allow=allow)
        self._log: RosoutLog | None = None
        try:
            self._log = None if log_file is None else RosoutLog(log_file)
            Loggers(self.node.service_server)
            self._out = self.node.publisher("/rosout_agg", message_class(LOG), queue_size=QUEUE)
            self.node.subscriber("/rosout", message_class(LOG), self._pass_on, raw=True, queue_size=QUEUE)
        except BaseException:
            self.close()
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
        if self._log is not None:
            self._log.close()

    def _pass_on(self, message: Any) -> None:
        if self.node.closed:
            return
        self._out.publish(message)
        if self._log is not None:
            try:
                self._log.add(decode(self._out.message_class, message._buff))
            except CodecError as error:
                _logger.debug("! a record of /rosout cannot be read: %s", error)
