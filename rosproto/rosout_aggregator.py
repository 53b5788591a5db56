"""roscore's node /rosout: republishes the messages of /rosout on /rosout_agg.

A tool that shows the log of the whole graph (rqt_console, rosbag record, `rostopic echo /rosout_agg`)
subscribes to one topic of one node instead of one of each node. Messages are forwarded as received, without
decoding.

Debian's node always writes a file as well; this one does if a path is given (`rosout_log`): one line for each
record, older files numbered.

    12.000000345 WARN /planner [plan.cpp:42(plan)] [topics: /rosout, /plan] no way to the goal

Unlike in Debian's file, further lines of a text are indented, so that no node can forge another node's
record.

Source: wiki.ros.org/rosout; ros_comm tools/rosout/rosout.cpp (format, sizes).
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable
from typing import IO

from rosproto.codec import AnyMsg, DynamicMessage, decode, message_class
from rosproto.errors import CodecError
from rosproto.files import replace_file
from rosproto.logs import get_logger
from rosproto.node.node import Node
from rosproto.node.rosout import LoggerServices
from rosproto.text import printable

__all__ = ["RosoutAggregator"]

_log = get_logger("rosproto.node")

MAX_FILE_BYTES = 100 << 20  # of one file
MAX_OLD_FILES = 10
_LEVELS = {1: "DEBUG", 2: "INFO", 4: "WARN", 8: "ERROR", 16: "FATAL"}

_LINES = "\n\t"  # allowed in a message
_INDENT = "    "  # of further lines, so that no record can be forged
_BYTES = "".join(map(chr, range(0xDC80, 0xDD00)))  # bytes that are not UTF-8 are written unchanged


class RosoutLog:
    """Appends records to a file; used by one thread.

    When the disk is full or gone, records are lost but the program goes on: a warning is logged once, and
    writing is tried again with the next record.

    Args:
        path: The file; older ones are `<path>.1` (the latest) to `<path>.10`.
        max_bytes: Size at which a new file is begun.

    Raises:
        OSError: It cannot be opened.
    """

    def __init__(self, path: str | os.PathLike[str], *, max_bytes: int = MAX_FILE_BYTES) -> None:
        self.path = os.fspath(path)
        self._max_bytes = max_bytes
        self._failing = False
        self._file: IO[str] | None = self._open()
        self._write(f"\n\n{time.time():.9f}  Node Startup\n")

    def add(self, record: DynamicMessage) -> None:
        """Write one rosgraph_msgs/Log."""
        sec, nanosec = record.header.stamp.secs, record.header.stamp.nsecs
        level = _LEVELS.get(record.level, str(record.level))
        place = f"{record.file}:{record.line}({record.function})"
        topics = ", ".join(record.topics)
        head = printable(f"{level} {record.name} [{place}] [topics: {topics}]", keep=_BYTES)
        text = printable(record.msg, keep=_BYTES + _LINES).replace("\n", "\n" + _INDENT)
        self._write(f"{sec}.{nanosec:09d} {head} {text}\n")

    def close(self) -> None:
        """Close the file. May be called again."""
        file, self._file = self._file, None
        if file is not None:
            file.close()

    def _open(self) -> IO[str]:
        return open(self.path, "a", encoding="utf-8", errors="surrogateescape", newline="\n", buffering=1)

    def _write(self, text: str) -> None:
        try:
            if self._file is None:
                self._file = self._open()
            self._file.write(text)
            if self._file.tell() > self._max_bytes:
                self._begin_next()
            self._failing = False
        except OSError as error:
            if not self._failing:
                _log.warning("! %s: not written: %s; trying again", self.path, error)
            self._failing = True

    def _begin_next(self) -> None:
        self.close()
        for number in range(MAX_OLD_FILES - 1, -1, -1):
            older = f"{self.path}.{number}" if number else self.path
            if os.path.exists(older):
                replace_file(older, f"{self.path}.{number + 1}")
        self._file = self._open()


LOG = "rosgraph_msgs/Log"
QUEUE = 1000  # messages; many nodes that start together send a burst


class RosoutAggregator:
    """Runs from construction until `close()`; usable in a `with`.

    Args:
        master_uri: The master.
        host: Address or name under which others reach this computer; None: the one that routes to the master.
        allow: Addresses that may connect; None for all.
        log_file: A file for the records, as Debian's rosout.log; None writes none.

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
            LoggerServices(self.node.service_server)
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
        """Close the node and the file. May be called again."""
        self.node.close()
        if self._log is not None:
            self._log.close()

    def _pass_on(self, message: AnyMsg) -> None:
        if self.node.closed:
            return
        self._out.publish(message)
        if self._log is not None:
            try:
                self._log.add(decode(message_class(LOG), message._buff))
            except CodecError as error:
                _log.debug("! a record of /rosout cannot be read: %s", error)
