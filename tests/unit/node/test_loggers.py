"""The log level services of a node."""

from __future__ import annotations

import logging

import pytest

from rosproto.errors import ServiceError
from rosproto.master import Master
from rosproto.node import Node
from rosproto.node.rosout import ros_level


def test_log_levels_are_told_and_set_by_name_only():
    with Master() as master, Node("/logging", master_uri=master.uri) as node:
        logging.getLogger("rosproto.test_levels").setLevel(logging.ERROR)
        levels = {
            entry.name: entry.level for entry in node.service_client("~get_loggers", None).call().loggers
        }
        assert levels["rosproto.test_levels"] == "error"
        client = node.service_client("~set_logger_level", "roscpp/SetLoggerLevel")
        client.call(logger="rosproto.test_levels", level="Debug")
        assert logging.getLogger("rosproto.test_levels").level == logging.DEBUG
        for wrong in (
            {"logger": "rosproto.test_level", "level": "info"},
            {"logger": "root", "level": "loud"},
        ):
            with pytest.raises(ServiceError, match=r"no logger|is not one of"):
                client.call(**wrong)
        assert "rosproto.test_level" not in logging.root.manager.loggerDict


@pytest.mark.parametrize(
    ("level", "name"),
    [(0, "debug"), (10, "debug"), (15, "debug"), (20, "info"), (35, "warn"), (50, "fatal"), (99, "fatal")],
)
def test_a_level_between_two_has_the_lower_name(level, name):
    assert ros_level(level)[0] == name
