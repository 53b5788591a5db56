"""/rosout out and in."""

from __future__ import annotations

import logging
import threading

from rosproto.master import Master
from rosproto.node import Node
from rosproto.node.rosout import log_messages


def test_the_nodes_logger_goes_to_rosout() -> None:
    """With level, place and text; latched, so that a late listener gets the last one."""
    with (
        Master() as master,
        Node("/talker", master_uri=master.uri) as node,
        Node("/listener", master_uri=master.uri, rosout=False) as other,
    ):
        node.logger.error("it is %s", "broken")
        heard = other.subscriber("/rosout", "rosgraph_msgs/Log").next(5)
        assert (heard.name, heard.msg, heard.level) == ("/talker", "it is broken", 8)
        assert heard.file == "test_node_rosout.py"
        assert heard.line > 0
        assert "/rosout" in heard.topics
        assert heard.header.stamp.secs > 1_600_000_000
    assert node.logger.handlers == []


def test_rosout_goes_to_a_logger_without_a_loop() -> None:
    """Other nodes' messages become records; our own do not come back, and none is sent again."""
    records: list[logging.LogRecord] = []
    came = threading.Event()

    class Keep(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            records.append(record)
            came.set()

    with (
        Master() as master,
        Node("/talker", master_uri=master.uri) as talker,
        Node("/both", master_uri=master.uri) as both,
    ):
        logger = both.logger  # the worst choice: it has the handler that publishes
        logger.addHandler(Keep())
        log_messages(both, logger).wait_for_connection()
        talker.logger.warning("once")
        assert came.wait(5)
        assert [(r.getMessage(), r.levelno, r.ros_node) for r in records] == [  # type: ignore[attr-defined]
            ("once", logging.WARNING, "/talker")
        ]
        assert both._rosout is not None
        assert sum(link.messages for link in both._rosout._publisher.stats()) == 0
        logger.handlers.clear()
