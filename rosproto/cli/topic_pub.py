"""`rosproto topic pub`: publish once (latched for three seconds with -1), at a rate, or from a file."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rosproto.codec import Message, message_class
from rosproto.codec.dicts import from_dict
from rosproto.errors import RosTimeout
from rosproto.time import Time
from rosproto.values import parse_value

from .graph import CommandError, library_for, open_node, print_json
from .yaml_text import load_text

__all__ = ["add_arguments", "run"]

LINGER = 3.0  # seconds that -1 stays, as rostopic does, for subscribers that are still connecting


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of rostopic pub."""
    parser.add_argument("topic")
    parser.add_argument("type", help="package/Type")
    parser.add_argument(
        "values", nargs="*", help="{field: value}, or the fields in order; now and auto for times"
    )
    parser.add_argument("-r", "--rate", type=float, default=None, help="publish this often, per second")
    parser.add_argument("-1", "--once", action="store_true", help="publish one message and end")
    parser.add_argument(
        "-f", "--file", default=None, help="take the values from a YAML or JSON file, - is stdin"
    )
    parser.add_argument("-l", "--latch", action="store_true", help="latch also with -r")
    parser.add_argument(
        "-s", "--substitute-keywords", action="store_true", help="accepted: now and auto always work"
    )
    parser.add_argument("--use-rostime", action="store_true", help="accepted for rostopic's sake")
    parser.add_argument("-n", type=int, default=None, metavar="COUNT", help="with -r: stop after this many")


def run(arguments: argparse.Namespace) -> int:
    """Publish; latched unless a rate is asked for."""
    if arguments.rate is not None and not arguments.rate > 0:
        raise CommandError(f"--rate {arguments.rate}: must be above 0 messages a second")
    cls = message_class(arguments.type, library_for(arguments, arguments.type))
    messages = list(_values(arguments))
    for value in messages:
        from_dict(cls, value, now=Time(1, 0))  # wrong values are told before anything is announced
    with open_node(arguments) as node:
        latch = arguments.latch or arguments.rate is None
        with node.publisher(arguments.topic, cls, latch=latch, queue_size=100) as publisher:
            if arguments.rate is not None:
                return _at_rate(publisher, cls, messages, arguments)
            return _latched(publisher, cls, messages, arguments)


def _values(arguments: argparse.Namespace) -> Iterator[Any]:
    if arguments.file is None:
        yield _typed(arguments.values)
        return
    if arguments.values:
        raise CommandError("give values or --file, not both")
    try:
        text = sys.stdin.read() if arguments.file == "-" else Path(arguments.file).read_text("utf-8")
    except OSError as error:
        raise CommandError(f"cannot read {arguments.file}: {error.strerror}") from error
    for part in text.split("\n---"):
        if part.strip():
            yield load_text(part.strip(), arguments.file)


def _typed(words: list[str]) -> Any:
    values = [parse_value(word) for word in words]
    if not values:
        return None
    return values[0] if len(values) == 1 else values


def _latched(publisher: Any, cls: type[Message], messages: list[Any], arguments: argparse.Namespace) -> int:
    for value in messages:
        publisher.publish(from_dict(cls, value, now=Time.from_sec(time.time())))
    if not arguments.once:
        if not arguments.json:
            print("publishing and latching message. Press ctrl-C to terminate", flush=True)
        while True:
            time.sleep(0.5)
    if not arguments.json:
        print(f"publishing and latching message for {LINGER} seconds", flush=True)
    time.sleep(LINGER)
    if arguments.json:
        print_json({"published": len(messages), "connections": publisher.connections})
    return 0


def _at_rate(publisher: Any, cls: type[Message], messages: list[Any], arguments: argparse.Namespace) -> int:
    try:
        publisher.wait_for_connection(timeout=1.0)  # else the first messages go to nobody
    except RosTimeout:
        pass  # nobody listens yet: publish all the same, as rostopic does
    period = 1.0 / arguments.rate
    due = time.monotonic()
    sent = 0
    while arguments.n is None or sent < arguments.n:
        value = messages[sent % len(messages)]
        publisher.publish(from_dict(cls, value, now=Time.from_sec(time.time())))
        sent += 1
        due += period
        time.sleep(max(0.0, due - time.monotonic()))
    publisher.flush()
    return 0
