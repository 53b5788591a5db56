"""Entry of the `rosproto` command: its sub-commands, their examples and their parser.

A command module has

    def add_arguments(parser: argparse.ArgumentParser) -> None: ...
    def run(arguments: argparse.Namespace) -> int | None: ...   # exit code; None: done

and a line in `COMMANDS`. One with verbs passes them to `graph_options.add_verbs` and has no `run`. Only the
module of the given command is imported.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence
from typing import NamedTuple

from rosproto.cli.exit_codes import DONE, EXIT_CODES, FAILED, INTERRUPTED, TERMINATED, UNREACHABLE, say
from rosproto.cli.output import Output
from rosproto.cli.parser import Parser, give_examples, leaves
from rosproto.cli.process import Task, exit_codes_line, run_command, words_of
from rosproto.version import __version__

MEANT = {
    **{verb: f"rosproto topic {verb}" for verb in ("echo", "hz", "bw", "pub", "list", "delay")},
    **{verb: f"rosproto bag {verb}" for verb in ("record", "play", "convert", "export", "info")},
    **{verb: f"rosproto service {verb}" for verb in ("call",)},
    **{verb: f"rosproto param {verb}" for verb in ("get", "set")},
    **dict.fromkeys(("core", "roscore", "rosmaster"), "rosproto master"),
    "help": "rosproto --help",
}
"""What is meant by words that are not commands."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run `rosproto` with these arguments (default: `sys.argv`) and return the exit code."""
    words = behind_the_verb(words_of(argv))
    if words[:1] == ["run"] and words[1:2] not in (["-h"], ["--help"]):
        # Start quickly: do not build the parsers of all sub-commands.
        from rosproto.rospy.launch import main as run_program

        return run_program(words[1:], prog="rosproto run")
    return run_command(words, parser_for, _task, until_exit=argv is None)


_WITHOUT_VERBS = ("graph", "doctor", "bridge", "foxglove", "run", "master", "completion")


def behind_the_verb(words: Sequence[str]) -> list[str]:
    """Move leading options behind the verb: `--master URI topic list` is `topic list --master URI`."""
    early: list[str] = []
    rest = list(words)
    while rest and rest[0].partition("=")[0] in (
        "--master",
        "--msg-path",
        "--resolve",
        "--json",
        "--no-learned",
    ):
        takes_value = rest[0] in ("--master", "--msg-path", "--resolve")
        early += rest[: 1 + takes_value]
        del rest[: 1 + takes_value]
    # Options before the command go behind it and its verb: their parsers know these options.
    verb = rest[1:2] if rest[:1] and rest[0] not in _WITHOUT_VERBS else []
    at = 1 + sum(not word.startswith("-") for word in verb)
    return [*rest[:at], *early, *rest[at:]] if early else list(words)


def _task(arguments: argparse.Namespace) -> Task:
    def run() -> int:
        _log_to_stderr(arguments.verbose)
        arguments.out = Output(as_json=getattr(arguments, "json", False))
        code: int | None = arguments.run(arguments)
        # Messages of a damaged bag may be missing; see `bag_files.opened`.
        return code or (FAILED if getattr(arguments, "incomplete", False) else DONE)

    def failed(text: str, code: int) -> None:
        hint = "; try: rosproto doctor" if code == UNREACHABLE and arguments.command != "doctor" else ""
        if code not in (INTERRUPTED, TERMINATED):
            say(f"rosproto {arguments.command}: {text}{hint}")

    return Task(run, failed, arguments.debug)


def parser_for(words: Sequence[str]) -> Parser:
    """Return a parser with all commands by name, and the given one in full."""
    parser = Parser(
        prog="rosproto",
        description="ROS 1 without a ROS installation.",
        epilog=exit_codes_line(EXIT_CODES),
    )
    parser.meant = MEANT.get
    add_general_options(parser, 0, False)
    parser.add_argument("--version", action="version", version=f"rosproto {__version__}")
    choices = parser.add_subparsers(title="commands", metavar="COMMAND", dest="command")
    asked = next((word for word in words if word in COMMANDS), None)
    for name, command in COMMANDS.items():
        sub = choices.add_parser(name, help=command.help, description=command.help)
        if name == asked:
            command.add_arguments(sub)
            give_examples(sub, EXAMPLES)
            for place in {id(p): p for p in (sub, *leaves(sub))}.values():
                add_general_options(place, argparse.SUPPRESS, argparse.SUPPRESS)
    return parser


def add_general_options(parser: Parser, count: object, debug: object) -> None:
    """Add --debug and --verbose, before and after the command; `topic list -v` keeps rostopic's meaning."""
    taken = parser.options
    names = [name for name in ("-v", "--verbose") if name not in taken]
    if names:
        parser.add_argument(
            *names, dest="verbose", action="count", default=count, help="log; twice: everything"
        )
    if "--debug" not in taken:
        parser.add_argument(
            "--debug", action="store_true", default=debug, help="show the traceback of an error"
        )


def _log_to_stderr(verbosity: int) -> None:
    import logging

    level = (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbosity, 2)]
    logging.basicConfig(level=level, format="%(asctime)s %(levelname)s %(message)s", stream=sys.stderr)


class Command(NamedTuple):
    """One sub-command.

    Attributes:
        module: The module of its functions.
        help: One line for `rosproto --help`.
        arguments: The function that adds its arguments.
    """

    module: str
    help: str
    arguments: str = "add_arguments"

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Import the module and add its arguments; parsing sets `run`, the function to call with them."""
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
    "bag": Command("rosproto.cli.bag", "record, play, inspect, repair and convert bags (rosbag)"),
    "graph": Command("rosproto.cli.graph", "draw who talks to whom: text, SVG, Graphviz, PNG"),
    "tf": Command("rosproto.cli.tf", "show the tree of frames, its rates, and transforms in it"),
    "log": Command("rosproto.cli.log", "read what nodes log, filtered; set their levels (rosconsole)"),
    "dynparam": Command("rosproto.cli.dynparam", "read and set what can be reconfigured (dynparam)"),
    "doctor": Command("rosproto.cli.doctor", "find out why a graph does not work from here"),
    "run": Command("rosproto.rospy.launch", "run a program written for rospy"),
    "bridge": Command(
        "rosproto.cli.gateway", "serve web pages and programs without ROS (rosbridge)", "add_bridge_arguments"
    ),
    "foxglove": Command(
        "rosproto.cli.gateway", "show the graph live in Foxglove and Lichtblick", "add_foxglove_arguments"
    ),
    "master": Command("rosproto.cli.master", "run a ROS master (what roscore does) until interrupted"),
    "completion": Command("rosproto.cli.completion", "print what a shell needs to complete this command"),
}


EXAMPLES: dict[str, tuple[str, ...]] = {
    "topic list": ("rosproto topic list -v", "rosproto topic list '/camera*'"),
    "topic echo": (
        "rosproto topic echo /odom -n 1",
        "rosproto topic echo /odom/pose/pose/position/x --plot",
        "rosproto topic echo /odom/twist/twist/linear/x /odom/twist/twist/angular/z --plot",
        "rosproto topic echo /scan --noarr --filter 'm.range_max > 10'",
    ),
    "topic hz": ("rosproto topic hz /odom /scan",),
    "topic pub": (
        "rosproto topic pub -1 /greeting std_msgs/String 'data: hello'",
        "rosproto topic pub -r 10 /cmd_vel geometry_msgs/Twist '{linear: {x: 0.1}}'",
    ),
    "service call": ("rosproto service call /lamp '{data: true}'",),
    "param set": ("rosproto param set /lamp '{watts: 60, name: desk}'",),
    "msg show": ("rosproto msg show nav_msgs/Odometry", "rosproto msg show Odometry --raw"),
    "bag record": (
        "rosproto bag record /odom /scan -O drive.bag --lz4",
        "rosproto bag record -a --split --duration 5m --max-splits 12",
    ),
    "bag play": (
        "rosproto bag play drive.bag -r 2 --clock",
        "rosproto bag play drive.bag /odom:=/before",
    ),
    "bag filter": (
        "rosproto bag filter drive.bag slow.bag \"topic == '/odom' and m.twist.twist.linear.x < 0.1\"",
    ),
    "graph": ("rosproto graph -o graph.svg", "rosproto graph --node /move_base"),
    "tf echo": ("rosproto tf echo map base_link -n 1",),
    "tf frames": ("rosproto tf frames -o frames.svg",),
    "tf monitor": ("rosproto tf monitor -n 1", "rosproto tf monitor map base_link -n 1"),
    "log echo": ("rosproto log echo --level warn --node '/move_base*'",),
    "log set": ("rosproto log set /move_base root debug",),
    "dynparam set": ("rosproto dynparam set /camera '{size: 20, enabled: false}'",),
    "bridge": (
        "rosproto bridge",
        "rosproto bridge --bind 0.0.0.0 --token Kd83-hsa2-Pq --allow-write 'topic:/chatter' --deny 'param:*'",
    ),
    "run": ("rosproto run program.py _speed:=0.2",),
    "master": ("rosproto master --host 0.0.0.0 --advertise 169.254.128.20",),
}
"""By command and verb."""
