"""`rosproto topic pub`: publish once (latched for a while with -1), at a rate, or from a file."""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from collections.abc import Iterable
from typing import TYPE_CHECKING

from rosproto.cli.background_output import never_wait_for_stdout
from rosproto.cli.console import is_terminal, warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import absolute, master_client, open_node
from rosproto.cli.graph_options import library_for
from rosproto.cli.yaml_values import fields_of, load_documents
from rosproto.codec import Message, message_class
from rosproto.codec.dicts import from_dict
from rosproto.errors import RosTimeout
from rosproto.files import read_text
from rosproto.time import Time

if TYPE_CHECKING:
    from rosproto.node import Publisher

LINGER = 3.0  # seconds that -1 stays, as rostopic does, for subscribers that are still connecting
FILE_RATE = 10.0  # messages per second from a file or standard input, as in rostopic


def run(arguments: argparse.Namespace) -> None:
    """Publish; latched unless a rate is asked for. A file's messages go out one by one, ten a second."""
    if arguments.values and arguments.file:
        raise ValueError("give values or --file, not both")
    cls = message_class(arguments.type, library_for(arguments, arguments.type))
    piped = arguments.file == "-" or not (arguments.file or arguments.values or not cls.__slots__)
    if piped and is_terminal(sys.stdin) and arguments.file is None:
        fields = ", ".join(f"{name}: ..." for name in cls.__slots__)
        raise ValueError(f"no values: write '{{{fields}}}', or the fields in order, or -f FILE")
    messages = [] if piped else _messages(arguments, cls)
    for value in messages:
        from_dict(cls, value, now=Time(1, 0))  # refuse wrong values before advertising
    _warn_of_another_type(arguments)
    never_wait_for_stdout()
    latch = arguments.latch or not (arguments.rate or arguments.n or piped or arguments.file)
    latch = latch or arguments.once
    with (
        open_node(arguments) as node,
        node.publisher(arguments.topic, cls, latch=latch, queue_size=100) as publisher,
    ):
        if piped:
            _in_turn(publisher, cls, load_documents(sys.stdin or (), "standard input"), arguments)
        elif arguments.file and not (arguments.rate or arguments.latch):
            _in_turn(publisher, cls, messages, arguments)
        elif arguments.rate or arguments.n:
            some = itertools.islice(itertools.cycle(messages), arguments.n)
            _in_turn(publisher, cls, some, arguments)
        else:
            _latched(publisher, cls, messages, arguments)


def _messages(arguments: argparse.Namespace, cls: type[Message]) -> list[object]:
    """Return the values of each message."""
    if arguments.file is None:
        return [fields_of(arguments.values, cls)]
    lines = read_text(arguments.file).splitlines(keepends=True)
    found = list(load_documents(lines, arguments.file))
    if not found:
        raise CommandError(f"{arguments.file} is empty; write a message, and `---` between two")
    return found


def _warn_of_another_type(arguments: argparse.Namespace) -> None:
    topic = absolute(arguments.topic)
    with master_client(arguments) as master:
        kind = master.get_topic_types().get(topic, "*")
    if kind not in ("*", arguments.type):
        warn(f"{topic} carries {kind}: its subscribers will not receive {arguments.type}")


def _latched(
    publisher: Publisher, cls: type[Message], messages: list[object], arguments: argparse.Namespace
) -> None:
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
    arguments.out.record({"published": len(messages), "connections": publisher.connections})


def _in_turn(
    publisher: Publisher, cls: type[Message], values: Iterable[object], arguments: argparse.Namespace
) -> None:
    """Publish each message once, at the rate."""
    try:
        publisher.wait_for_connection(timeout=1.0)  # otherwise the first messages are lost
    except RosTimeout:
        pass  # no subscriber: publish anyway, as rostopic does
    period = 1.0 / (arguments.rate or FILE_RATE)
    due = time.monotonic()
    sent = 0
    for value in values:
        publisher.publish(from_dict(cls, value, now=Time.from_sec(time.time())))
        sent += 1
        if arguments.once or sent == arguments.n:
            break
        due = max(due + period, time.monotonic())
        time.sleep(max(0.0, due - time.monotonic()))
    if sent == 0:
        raise CommandError("there was no message to publish: standard input ended at once")
    publisher.flush()
    if arguments.once:
        time.sleep(LINGER)
    arguments.out.record({"published": sent, "connections": publisher.connections})
