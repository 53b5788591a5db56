"""The sub-commands of `rosproto`, and the module of each.

A command module has

    def add_arguments(parser: argparse.ArgumentParser) -> None: ...
    def run(arguments: argparse.Namespace) -> int: ...        # exit code

and a line here. One with verbs hands them to `connection.verbs` and has no `run`. Only the module of the
command that is run gets imported, so `rosproto master` starts without what `rosproto topic` needs.
"""

from __future__ import annotations

import argparse
import importlib
from typing import NamedTuple

__all__ = ["COMMANDS", "Command"]


class Command(NamedTuple):
    """One sub-command.

    Attributes:
        module: Where its functions are.
        help: One line for `rosproto --help`.
        arguments: Name of the function that adds its arguments.
    """

    module: str
    help: str
    arguments: str = "add_arguments"

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Import it and give the parser its arguments; parsing sets `run`, the function to call with them."""
        module = importlib.import_module(self.module)
        getattr(module, self.arguments)(parser)
        if hasattr(module, "run"):
            parser.set_defaults(run=module.run)


COMMANDS: dict[str, Command] = {
    "topic": Command("rosproto.cli.topic", "list, watch, measure and publish topics (rostopic)"),
    "node": Command("rosproto.cli.node", "list, inspect, ping and end nodes (rosnode)"),
    "service": Command("rosproto.cli.service", "list, inspect and call services (rosservice)"),
    "param": Command("rosproto.cli.param", "get and set parameters (rosparam)"),
    "msg": Command("rosproto.cli.definitions", "show message definitions (rosmsg)", "add_arguments_msg"),
    "srv": Command("rosproto.cli.definitions", "show service definitions (rossrv)", "add_arguments_srv"),
    "action": Command("rosproto.cli.definitions", "show action definitions", "add_arguments_action"),
    "bag": Command("rosproto.cli.bag", "record, play, inspect, mend and convert bags (rosbag)"),
    "graph": Command("rosproto.cli.graph", "draw who talks to whom: text, SVG, Graphviz, PNG"),
    "tf": Command("rosproto.cli.tf", "show the tree of frames, its rates, and transforms in it"),
    "log": Command("rosproto.cli.log", "read what nodes log, filtered; set their levels (rosconsole)"),
    "dynparam": Command("rosproto.cli.dynparam", "read and set what can be reconfigured (dynparam)"),
    "doctor": Command("rosproto.cli.doctor", "find out why a graph does not work from here"),
    "run": Command("rosproto.rospy.launch", "run a program written for rospy"),
    "bridge": Command("rosproto.cli.bridge", "serve web pages and programs without ROS (rosbridge)"),
    "foxglove": Command("rosproto.cli.foxglove", "show the graph live in Foxglove and Lichtblick"),
    "master": Command("rosproto.cli.master", "run a ROS master (what roscore does) until interrupted"),
    "completion": Command("rosproto.cli.completion", "print what a shell needs to complete this command"),
}
