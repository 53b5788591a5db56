"""/rosout: log records as messages, and the services for log levels."""

from __future__ import annotations

import logging
import subprocess
import sys

from rosproto.master import Master
from rosproto.node import Node


def test_the_nodes_logger_goes_to_rosout() -> None:
    """With level, place and text; latched, so that a late listener gets the last one."""
    with (
        Master() as master,
        Node("/talker", master_uri=master.uri) as node,
        Node("/listener", master_uri=master.uri, rosout=False) as other,
    ):
        node.logger.error("it is %s", "broken")
        heard = other.subscriber("/rosout", "rosgraph_msgs/Log").next(20)
        assert (heard.name, heard.msg, heard.level) == ("/talker", "it is broken", 8)
        assert heard.file == "test_node_rosout.py"
        assert heard.line > 0
        assert "/rosout" in heard.topics
        assert heard.header.stamp.secs > 1_600_000_000
    assert node.logger.handlers == []


def test_a_logger_by_name_is_the_nodes_own() -> None:
    with (
        Master() as master,
        Node("/quiet", master_uri=master.uri),
        Node("/listener", master_uri=master.uri, rosout=False) as listener,
    ):
        logging.getLogger("ros.quiet").error("by name")
        heard = listener.wait_for_message("/rosout", "rosgraph_msgs/Log", timeout=20)
        assert (heard.name, heard.msg) == ("/quiet", "by name")


def test_set_logger_level_works_in_a_program_that_does_not_log() -> None:
    code = (
        "import sys, rosproto\n"
        "with rosproto.Node('/quiet', master_uri=sys.argv[1]) as node:\n"
        "    node.service_client('~set_logger_level', 'roscpp/SetLoggerLevel').call(logger='root', level='debug')\n"
        "    loggers = node.service_client('~get_loggers', 'roscpp/GetLoggers').call().loggers\n"
        "    print([l.level for l in loggers if l.name == 'root'])\n"
    )
    with Master() as master:
        done = subprocess.run(
            [sys.executable, "-c", code, master.uri], capture_output=True, text=True, timeout=60, check=True
        )
        assert done.stdout == "['debug']\n"
