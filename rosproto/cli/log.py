"""`rosproto log`: live log messages of nodes, and their log levels (rosconsole, rqt_console)."""

from __future__ import annotations

import argparse
import re
import sys
import time
from typing import TYPE_CHECKING

from rosproto.cli.console import enable_escapes, warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import absolute, below, master_client, open_node, unknown
from rosproto.cli.graph_options import add_verbs
from rosproto.cli.options import argument, count, positive
from rosproto.errors import RosTimeout, ServiceError
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.codec import DynamicMessage
    from rosproto.node import Node

LEVELS = {"debug": 1, "info": 2, "warn": 4, "error": 8, "fatal": 16}
"""rosgraph_msgs/Log, as its definition numbers them."""
COLOURS = {1: "2", 4: "33", 8: "31", 16: "31;1"}
AGGREGATED, DIRECT = "/rosout_agg", "/rosout"
_TAB = "\t"
STEP = 0.5  # s; Windows delivers no Ctrl-C during an endless wait


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verbs."""
    add_verbs(
        parser,
        {
            "echo": (_echo_arguments, _echo, "print what nodes log, as it comes"),
            "list": (argument("node"), _list, "list the loggers of a node and their levels"),
            "get": (_get_arguments, _get, "print the level of a logger"),
            "set": (_set_arguments, _set, "set the level of a logger"),
        },
    )


def _level(text: str) -> int:
    level = LEVELS.get(text.lower())
    if level is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not a level; one of: {', '.join(LEVELS)}")
    return level


def _expression(text: str) -> re.Pattern[str]:
    try:
        return re.compile(text)
    except re.error as error:
        raise argparse.ArgumentTypeError(f"{text!r} is not a regular expression: {error}") from None


def _echo_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-l", "--level", type=_level, default=1, metavar="LEVEL", help="only these and worse: warn"
    )
    parser.add_argument(
        "--node", action="append", default=[], metavar="NAME", help="only of this node, or of '/camera*'"
    )
    parser.add_argument("--match", type=_expression, metavar="REGEX", help="only lines that contain this")
    parser.add_argument(
        "--exclude", type=_expression, metavar="REGEX", help="leave out lines that contain this"
    )
    parser.add_argument("-n", type=count, metavar="COUNT", help="stop after this many lines")
    parser.add_argument(
        "--timeout", type=positive, metavar="S", help="give up after S seconds without a line"
    )
    parser.add_argument("--source", action="store_true", help="with file, line and function")


def _get_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("node")
    parser.add_argument("logger")


def _set_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("node")
    parser.add_argument("logger", help="see: rosproto log list NODE")
    parser.add_argument("level", choices=tuple(LEVELS), type=str.lower)


# -- reading -------------------------------------------------------------------------------------------------


def _echo(arguments: argparse.Namespace) -> None:
    from queue import Empty, Queue

    from rosproto.codec import message_class

    with master_client(arguments) as master:
        state = master.get_system_state()
    for asked in arguments.node:
        if not below(state.nodes, asked):
            warn(f"no node is called {absolute(asked)} yet; its lines are shown when it appears")
    topic = AGGREGATED if state.publishers.get(AGGREGATED) else DIRECT
    came: Queue[DynamicMessage] = Queue()
    shown, silent_since = 0, time.monotonic()
    ours = message_class("rosgraph_msgs/Log")
    with open_node(arguments) as node, node.subscriber(topic, ours, came.put, queue_size=1000):
        while arguments.n is None or shown < arguments.n:
            try:
                line = came.get(timeout=min(STEP, arguments.timeout or STEP))
            except Empty:
                if arguments.timeout and time.monotonic() - silent_since >= arguments.timeout:
                    raise RosTimeout(
                        f"{topic}: no matching line within {arguments.timeout:g} s; "
                        "use fewer filters, or see: rosproto topic info " + topic
                    ) from None
                continue
            if _wanted(line, arguments):
                shown, silent_since = shown + 1, time.monotonic()
                _show(line, arguments)


def _wanted(line: DynamicMessage, arguments: argparse.Namespace) -> bool:
    if line.level < arguments.level:
        return False
    if arguments.node and not any(below([line.name], asked) for asked in arguments.node):
        return False
    if arguments.match and not arguments.match.search(line.msg):
        return False
    return not (arguments.exclude and arguments.exclude.search(line.msg))


def word_of(level: int) -> str:
    """Return the name of the highest level not above this one."""
    return next((name for name, number in reversed(LEVELS.items()) if level >= number), "debug")


def _show(line: DynamicMessage, arguments: argparse.Namespace) -> None:
    stamp = line.header.stamp.to_sec()
    level = word_of(line.level)
    if arguments.json:
        arguments.out.record(
            {
                "stamp": stamp, "level": level, "node": line.name, "text": line.msg,
                "file": line.file, "line": line.line, "function": line.function,
            }
        )  # fmt: skip
        return
    clock = time.strftime("%H:%M:%S", time.localtime(stamp)) + f".{line.header.stamp.nsecs // 1_000_000:03d}"
    head, *more = line.msg.split("\n")
    text = f"{clock} {level.upper():5s} {printable(line.name)}: {printable(head, keep=_TAB)}"
    text += "".join(f"\n{'':18s} {printable(part, keep=_TAB)}" for part in more)
    if arguments.source:
        text += printable(f"  [{line.file}:{line.line} {line.function}]")
    colour = COLOURS.get(LEVELS[level]) if enable_escapes(sys.stdout) else None
    print(f"\x1b[{colour}m{text}\x1b[0m" if colour else text, flush=True)


# -- levels --------------------------------------------------------------------------------------------------


def _call(
    arguments: argparse.Namespace, node: Node, service: str, kind: str, **fields: object
) -> DynamicMessage:
    from rosproto.codec import service_class

    name = f"{absolute(arguments.node)}/{service}"
    with master_client(arguments) as master:
        state = master.get_system_state()
    if name not in state.services:
        if absolute(arguments.node) not in state.nodes:
            raise unknown("the master knows no node", arguments.node, state.nodes, "node list")
        raise CommandError(
            f"{absolute(arguments.node)} has no {service}: it cannot be asked about its loggers"
        )
    with node.service_client(name, service_class(kind)) as client:
        reply: DynamicMessage = client.call(timeout=5.0, **fields)
        return reply


def _loggers(arguments: argparse.Namespace) -> dict[str, str]:
    with open_node(arguments) as node:
        reply = _call(arguments, node, "get_loggers", "roscpp/GetLoggers")
    return {logger.name: logger.level for logger in reply.loggers}


def _level_now(arguments: argparse.Namespace) -> str:
    """Return the level of the logger; an unknown logger is an error."""
    found = _loggers(arguments)
    if arguments.logger not in found:
        raise unknown("no logger is called", arguments.logger, found, f"log list {arguments.node}")
    return found[arguments.logger]


def _list(arguments: argparse.Namespace) -> None:
    found = dict(sorted(_loggers(arguments).items()))
    arguments.out.answer(found, [f"{printable(name)} {printable(level)}" for name, level in found.items()])


def _get(arguments: argparse.Namespace) -> None:
    level = _level_now(arguments)
    arguments.out.answer(level, printable(level))


def _set(arguments: argparse.Namespace) -> int:
    _level_now(arguments)
    with open_node(arguments) as node:
        try:
            _call(
                arguments, node, "set_logger_level", "roscpp/SetLoggerLevel",
                logger=arguments.logger, level=arguments.level,
            )  # fmt: skip
        except ServiceError as error:
            raise CommandError(f"{absolute(arguments.node)} did not accept the level: {error}") from error
    now = _loggers(arguments).get(arguments.logger, "unknown")
    arguments.out.answer({"logger": arguments.logger, "level": now}, f"{arguments.logger}: {printable(now)}")
    return 0 if now.lower() == arguments.level else 1
