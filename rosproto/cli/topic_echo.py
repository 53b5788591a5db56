"""`rosproto topic echo`: messages as text, CSV, JSON or a plot, of types nobody has installed too."""

from __future__ import annotations

import argparse
import fnmatch
import sys
import time
from collections import deque
from typing import Any

from rosproto.codec import strify_message
from rosproto.codec.dicts import to_dict
from rosproto.errors import RosTimeout
from rosproto.time import Time

from .expression import Expression
from .field_path import parse_field_path, split_topic
from .graph import CommandError, master_client, open_node, print_json
from .message_csv import header, row
from .message_view import Abbreviation

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of rostopic echo, and ours."""
    parser.add_argument("topic", help="a topic, with a path to a field behind it: /odom/pose/pose/position/x")
    parser.add_argument("-n", type=int, default=None, metavar="COUNT", help="stop after this many messages")
    parser.add_argument("-p", "--csv", action="store_true", dest="csv", help="one line of CSV a message")
    parser.add_argument("-c", "--clear", action="store_true", help="clear the screen before each message")
    parser.add_argument(
        "--filter", metavar="EXPRESSION", help='only messages for which it is true: "m.x > 1"'
    )
    parser.add_argument("--noarr", action="store_true", help="tell the size of arrays, not their elements")
    parser.add_argument("--nostr", action="store_true", help="leave strings out")
    parser.add_argument("-b", "--bag", metavar="FILE", help="read messages from a bag, not from a graph")
    parser.add_argument("--plot", action="store_true", help="draw a number over time in the terminal")
    parser.add_argument("-w", type=int, default=None, metavar="WIDTH", dest="width", help="width of numbers")
    parser.add_argument(
        "--timeout", type=float, default=None, help="give up when no message comes for this long"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print until interrupted, or until -n messages."""
    printer = _Printer(arguments)
    if arguments.bag:
        _from_bag(arguments, printer)
    else:
        _from_graph(arguments, printer)
    return 0


def _from_graph(arguments: argparse.Namespace, printer: _Printer) -> None:
    with master_client(arguments) as master:
        types = master.get_topic_types()
    asked = arguments.topic if arguments.topic.startswith("/") else "/" + arguments.topic
    topic, path = split_topic(asked, list(types))
    if topic not in types:
        print(f"WARNING: topic [{topic}] does not appear to be published yet", file=sys.stderr)
    printer.take = parse_field_path(path)
    printer.path = path
    with open_node(arguments) as node, node.subscriber(topic, None, queue_size=1000) as messages:
        while not printer.done:
            try:
                # In short steps, because Windows delivers no Ctrl-C to a thread in an endless wait.
                message, received = messages.next_stamped(timeout=arguments.timeout or 1.0)
            except RosTimeout:
                if arguments.timeout is None:
                    continue
                raise
            printer.show(message, Time.from_sec(received))


def _from_bag(arguments: argparse.Namespace, printer: _Printer) -> None:
    from rosproto.bag import BagReader

    with BagReader(arguments.bag) as bag:
        topics = sorted(bag.topics)
        topic, path = split_topic(arguments.topic, topics)
        wanted = fnmatch.filter(topics, topic)
        if not wanted:
            raise CommandError(
                f"{arguments.bag} has no topic {topic!r}; it has: {', '.join(topics) or 'none'}"
            )
        printer.take = parse_field_path(path)
        printer.path = path
        for _, message, stamp in bag.read_messages(topics=wanted):
            printer.show(message, stamp)
            if printer.done:
                return


class _Printer:
    """Prints messages one after the other in the form that was asked for."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments = arguments
        self.filter = Expression(arguments.filter) if arguments.filter else None
        self.view = Abbreviation(no_arrays=arguments.noarr, no_strings=arguments.nostr)
        self.take = parse_field_path("")
        self.path = ""
        self.shown = 0
        self.history: deque[float] = deque(maxlen=120)

    @property
    def done(self) -> bool:
        """-n messages were shown."""
        return self.arguments.n is not None and self.shown >= self.arguments.n

    def show(self, message: Any, received: Time) -> None:
        """Print one message, unless the filter says no."""
        if self.filter is not None and not self.filter(m=message):
            return
        value = self.take(message)
        self.shown += 1
        if self.arguments.clear:
            sys.stdout.write("\033[2J\033[;H")
        if self.arguments.csv:
            self._csv(value, received)
        elif self.arguments.plot:
            self._plot(value)
        elif self.arguments.json:
            print_json(to_dict(value, finite=True) if hasattr(value, "__slots__") else _plain(value))
        else:
            print(self._text(value) + "\n---")
        sys.stdout.flush()

    def _text(self, value: Any) -> str:
        return strify_message(self.view(value)).lstrip("\n")

    def _csv(self, value: Any, received: Time) -> None:
        value = self.view(value)
        if self.shown == 1:
            print("%time," + header(value, "field"))
        stamp = value.header.stamp if getattr(value, "_has_header", False) else received
        print(f"{stamp.to_nsec()},{row(value)}")

    def _plot(self, value: Any) -> None:
        from .sparkline import plot

        if not isinstance(value, (int, float)):
            raise CommandError(
                "--plot draws one number: name a field, such as /odom/twist/twist/linear/x; "
                f"{self.path or self.arguments.topic} is {getattr(value, '_type', type(value).__name__)}"
            )
        self.history.append(float(value))
        title = f"{self.arguments.topic}  {value:.6g}  {time.strftime('%H:%M:%S')}"
        if sys.stdout.isatty():
            sys.stdout.write("\033[2J\033[;H")
        print(title + "\n" + plot(list(self.history)))


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, list):
        return [to_dict(item, finite=True) if hasattr(item, "_slot_types") else item for item in value]
    return value
