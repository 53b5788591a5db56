"""/rosout: log records as messages, and the services for log levels."""

from __future__ import annotations

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


def test_a_logger_by_name_is_heard_though_logging_came_later_than_the_node() -> None:
    """Nothing imports `logging` for a node; once the program does, its logger publishes within a second or so."""
    code = (
        "import sys, time, rosproto\n"
        "with rosproto.Node('/quiet', master_uri=sys.argv[1]) as node:\n"
        "    before = 'logging' in sys.modules\n"
        "    import logging\n"
        "    logger, end = logging.getLogger('ros.quiet'), time.monotonic() + 20\n"
        "    while not logger.handlers and time.monotonic() < end: time.sleep(0.01)\n"
        "    logger.error('at last')\n"
        "    print(before, flush=True)\n"
        "    sys.stdin.readline()\n"
    )
    with (
        Master() as master,
        Node("/listener", master_uri=master.uri, rosout=False) as listener,
        subprocess.Popen(
            [sys.executable, "-c", code, master.uri], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as process,
    ):
        assert process.stdout is not None
        assert process.stdout.readline() == "False\n"
        heard = listener.wait_for_message("/rosout", "rosgraph_msgs/Log", timeout=20)
        assert (heard.name, heard.msg) == ("/quiet", "at last")
        process.communicate("\n", timeout=20)


def test_set_logger_level_works_in_a_program_without_logging() -> None:
    code = (
        "import sys, rosproto\n"
        "with rosproto.Node('/quiet', master_uri=sys.argv[1]) as node:\n"
        "    before = 'logging' in sys.modules\n"
        "    node.service_client('~set_logger_level', 'roscpp/SetLoggerLevel').call(logger='root', level='debug')\n"
        "    loggers = node.service_client('~get_loggers', 'roscpp/GetLoggers').call().loggers\n"
        "    print(before, [l.level for l in loggers if l.name == 'root'])\n"
    )
    with Master() as master:
        done = subprocess.run(
            [sys.executable, "-c", code, master.uri], capture_output=True, text=True, timeout=60, check=True
        )
        assert done.stdout == "False ['debug']\n"
