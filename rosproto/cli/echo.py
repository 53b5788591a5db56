"""What `rosproto topic echo` does: messages as text, CSV, JSON or a plot; of types nobody installed too."""

from __future__ import annotations

import argparse
import fnmatch
import os
import sys
import time
from collections.abc import Iterator
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from rosproto.codec import strify_message
from rosproto.codec.dicts import plain
from rosproto.errors import RosTimeout
from rosproto.text import printable
from rosproto.time import Time

from .connection import CommandError, absolute, below, master_client, open_node, print_json, warn
from .console import clear, enable_escapes, is_terminal, shows_unicode, terminal_size
from .counts import counted
from .expression import Expression
from .field_path import parse_field_path, split_topic
from .message_csv import header, row
from .message_view import View
from .parser import near

if TYPE_CHECKING:
    from .curves import Curves

__all__ = ["run"]

REDRAW = 0.1
"""Least seconds between two pictures on a terminal."""
PATIENCE = 3.0
"""Seconds of silence after which one warning says why nothing may be coming."""

Arrival = tuple[str, Any, Time]
"""Topic, message, when it was received."""


def run(arguments: argparse.Namespace) -> int:
    """Print until interrupted, or until -n messages."""
    if arguments.all and not arguments.bag:
        raise ValueError("--all is for --bag; on a graph a pattern such as '/*' names several topics")
    if arguments.plot and (arguments.json or arguments.csv):
        raise ValueError("--plot draws; leave --json or -p out")
    if not arguments.plot and (arguments.topics or arguments.seconds):
        raise ValueError(
            "several topics are for --plot; without it name one, or a pattern such as '/battery*'"
        )
    printer = _Printer(arguments)
    if arguments.bag:
        _from_bag(arguments, printer)
    else:
        _from_graph(arguments, printer)
    return 0


def _from_graph(arguments: argparse.Namespace, printer: _Printer) -> None:
    with master_client(arguments) as master:
        types = master.get_topic_types()
    asked = absolute(arguments.topic)
    topic, path = split_topic(asked, list(types))
    topics = [topic]
    if topic not in types:
        # A "[" alone is the begin of an index: /scan/ranges[0] of a scan that is still to come.
        topics = below(types, asked) if "*" in asked or "?" in asked else [topic]
        if not topics:
            raise CommandError(f"no topic matches {asked!r}; see: rosproto topic list")
        if topics == [topic]:
            warn(f"topic [{topic}] does not appear to be published yet{near(topic, types)}")
    printer.choose(topics, path)
    topics = printer.choose_more(list(types))
    with open_node(arguments) as node:
        for arrival in _arrivals(node, topics, arguments.timeout):
            printer.show(*arrival)
            if printer.done:
                return


def _arrivals(node: Any, topics: list[str], timeout: float | None) -> Iterator[Arrival]:
    """Messages as they come, of all topics."""
    came: SimpleQueue[Arrival] = SimpleQueue()
    subscribers = [node.subscriber(topic, None, _put(came, topic), queue_size=1000) for topic in topics]
    began, told = time.monotonic(), False
    while True:
        try:
            # In short steps, because Windows delivers no Ctrl-C to a thread in an endless wait.
            yield came.get(timeout=0.5 if timeout is None else min(timeout, 0.5))
            began, told = time.monotonic(), True
        except Empty:
            silent = time.monotonic() - began
            if timeout is not None and silent >= timeout:
                raise RosTimeout(_silence(topics, subscribers, timeout)) from None
            if silent > PATIENCE and not told and timeout is None:
                warn(_silence(topics, subscribers, silent) + "; still listening, Ctrl-C ends it")
                told = True


def _put(came: SimpleQueue[Arrival], topic: str) -> Any:
    return lambda message: came.put((topic, message, Time.from_sec(time.time())))


def _silence(topics: list[str], subscribers: list[Any], seconds: float) -> str:
    connected = sum(subscriber.connections for subscriber in subscribers)
    if connected:
        who = f"{counted(connected, 'publisher')} connected"
    elif any(subscriber.stats() for subscriber in subscribers):
        named = [subscriber for subscriber in subscribers if subscriber.stats()]
        who = f"its publisher cannot be reached: {'; '.join(each.why_silent() for each in named)}"
    else:
        who = "nobody publishes it"
    return f"{', '.join(topics)}: no message within {seconds:g} s; {who}"


def _from_bag(arguments: argparse.Namespace, printer: _Printer) -> None:
    from .bag_opening import opened

    with opened(arguments.bag, arguments) as bag:
        topics = sorted(bag.topics)
        topic, path = split_topic(arguments.topic, topics)
        wanted = topics if arguments.all else [topic] if topic in topics else fnmatch.filter(topics, topic)
        if not wanted:
            raise CommandError(
                f"{arguments.bag} has no topic {topic!r}{near(topic, topics)}; "
                f"it has: {', '.join(topics) or 'none'}"
            )
        printer.choose(wanted, path)
        wanted = printer.choose_more(topics)
        for name, message, stamp in bag.read_messages(topics=wanted):
            printer.show(name, message, stamp)
            if printer.done:
                return


class _Printer:
    """Prints messages one after the other in the form that was asked for."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments = arguments
        self.filter = Expression(arguments.filter, ("m", "topic")) if arguments.filter else None
        since = Time.from_sec(time.time()) if arguments.offset else None
        self.view = View(no_arrays=arguments.noarr, no_strings=arguments.nostr, since=since)
        self.take = parse_field_path("")
        self.several = False
        self.topics: list[str] = []
        self.shown = 0
        self.drawn: list[tuple[str, Any]] = []  # topic and what takes the number out of its messages
        self.curves: Curves | None = None
        self.due = 0.0

    def choose(self, topics: list[str], path: str) -> None:
        """What will be shown.

        Raises:
            ValueError: The path is malformed, or the form is for one topic only.
        """
        self.take = parse_field_path(path, f"{topics[0]}/{path}")
        self.topics = topics
        self.several = len(topics) > 1
        if self.several and (self.arguments.csv or self.arguments.plot):
            raise ValueError(f"-p and --plot are for one topic, and these are {len(topics)}: name one")

    def choose_more(self, known: list[str]) -> list[str]:
        """The topics of all curves of --plot, the first one's first; else those of `choose`."""
        if not self.arguments.plot:
            return self.topics
        from .curves import Curves

        self.drawn = [(self.topics[0], self.take)]
        for asked in self.arguments.topics:
            topic, path = split_topic(absolute(asked), known)
            if topic not in known:
                warn(f"topic [{topic}] does not appear to be published yet{near(topic, known)}")
            self.drawn.append((topic, parse_field_path(path, f"{topic}/{path}")))
        seconds = self.arguments.seconds or (None if self.arguments.bag else 30.0)
        self.curves = Curves([self.arguments.topic, *self.arguments.topics], seconds)
        return list(dict.fromkeys(topic for topic, _ in self.drawn))

    @property
    def done(self) -> bool:
        """-n messages were shown."""
        return self.arguments.n is not None and self.shown >= self.arguments.n

    def show(self, topic: str, message: Any, received: Time) -> None:
        """Print one message, unless the filter says no."""
        if self.filter is not None and not self.filter(m=message, topic=topic):
            return
        self.shown += 1
        if self.curves is not None:
            self._plot(self.curves, topic, message, received)
            sys.stdout.flush()
            return
        value = self.take(message)
        if self.arguments.clear:
            clear(sys.stdout)
        if self.arguments.offset and not self.arguments.bag:
            self.view.since = Time.from_sec(time.time())
        if self.arguments.csv:
            self._csv(value, received)
        elif self.arguments.json:
            shown = plain(value, finite=True)
            print_json({"topic": topic, "message": shown} if self.several else shown)
        else:
            print(
                (f"# {printable(topic)}\n" if self.several and not self.arguments.all else "")
                + self._text(value)
                + "\n---"
            )
        sys.stdout.flush()

    def _text(self, value: Any) -> str:
        return strify_message(self.view(value), width=self.arguments.width)

    def _csv(self, value: Any, received: Time) -> None:
        stamp = value.header.stamp if getattr(value, "_has_header", False) else received
        value = self.view(value)
        if self.shown == 1:
            print("%time," + header(value, "field"))
        since = self.view.since
        print(f"{stamp.to_nsec() - (since.to_nsec() if since else 0)},{row(value, one_line=True)}")

    def _plot(self, curves: Curves, topic: str, message: Any, received: Time) -> None:
        for index, (drawn, take) in enumerate(self.drawn):
            if drawn != topic:
                continue
            value = take(message)
            if not isinstance(value, (int, float)):
                kind = getattr(value, "_type", type(value).__name__)
                raise ValueError(
                    f"--plot draws numbers, and {curves.names[index]} is {kind}; "
                    "name a field, such as /odom/twist/twist/linear/x"
                )
            curves.add(index, received.to_sec(), float(value))
        live = is_terminal(sys.stdout)
        if live and time.monotonic() < self.due and not self.done:
            return
        self.due = time.monotonic() + REDRAW
        columns, lines = terminal_size()
        coloured = enable_escapes(sys.stdout) and not os.environ.get("NO_COLOR")
        titles = curves.legend(coloured)
        titles[-1] += time.strftime("  %H:%M:%S")
        height = max(1, min(lines - 1 - len(titles), 13))
        clear(sys.stdout)
        picture = curves.picture(
            min(columns - 1, 100),
            height if live else 9,
            # Dots of one colour cannot be told apart; signs can.
            ascii_only=not shows_unicode(sys.stdout) or (len(titles) > 1 and not coloured),
            coloured=coloured and len(titles) > 1,
        )
        print("\n".join([*(title if coloured else title[: columns - 1] for title in titles), picture]))
