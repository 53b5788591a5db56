"""`rosproto topic echo`: messages as text, CSV, JSON or curves, also of unknown types."""

from __future__ import annotations

import argparse
import fnmatch
import math
import os
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from queue import Empty, Queue
from typing import TYPE_CHECKING, Any, TypeAlias

from rosproto.cli.console import (
    clear,
    counted,
    enable_escapes,
    is_terminal,
    shows_unicode,
    terminal_size,
    warn,
)
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.expression import Expression
from rosproto.cli.fields import MissingElement, header, parse_field_path, row, split_topic
from rosproto.cli.graph_clients import absolute, below, master_client, open_node
from rosproto.cli.parser import near
from rosproto.codec import strify_message
from rosproto.codec.message import Message
from rosproto.errors import RosTimeout
from rosproto.json_values import plain
from rosproto.text import printable
from rosproto.time import Time

if TYPE_CHECKING:
    from rosproto.codec import DynamicMessage
    from rosproto.node import Node, Subscriber

REDRAW = 0.1
"""Least seconds between two pictures on a terminal."""
PATIENCE = 3.0
"""Seconds of silence after which one warning says why nothing may be coming."""

Arrival: TypeAlias = "tuple[str, DynamicMessage, Time]"
"""Topic, message, when it was received."""
Take = Callable[[object], object]
"""The getter of a field, from a message."""


def run(arguments: argparse.Namespace) -> None:
    """Print until interrupted, or -n messages."""
    if arguments.all and not arguments.bag:
        raise ValueError("--all is for --bag; on a graph a pattern such as '/*' names several topics")
    if arguments.topic is None and not arguments.all:
        raise ValueError("name a topic, or a pattern such as '/battery*'; --bag FILE --all needs none")
    if arguments.plot and (arguments.json or arguments.csv):
        raise ValueError("--plot draws; omit --json or -p")
    if not arguments.plot and (arguments.topics or arguments.seconds):
        raise ValueError(
            "several topics are for --plot; without it name one, or a pattern such as '/battery*'"
        )
    printer = _Printer(arguments)
    if arguments.bag:
        _from_bag(arguments, printer)
    else:
        _from_graph(arguments, printer)


def _from_graph(arguments: argparse.Namespace, printer: _Printer) -> None:
    with master_client(arguments) as master:
        types = master.get_topic_types()
    asked = absolute(arguments.topic)
    topic, path = split_topic(asked, list(types))
    topics = [topic]
    if topic not in types:
        # A single "[" begins an index, not a pattern: /scan/ranges[0] of a future scan.
        topics = below(types, asked) if "*" in asked or "?" in asked else [topic]
        if not topics:
            raise CommandError(f"no topic matches {asked!r}; see: rosproto topic list")
        if topics == [topic]:
            warn(f"topic [{topic}] does not appear to be published yet{near(topic, types)}")
    topics = printer.choose(topics, path, list(types))
    with open_node(arguments) as node:
        for arrival in _arrivals(node, topics, arguments.timeout):
            printer.show(*arrival)
            if printer.done:
                return


def _arrivals(node: Node, topics: list[str], timeout: float | None) -> Iterator[Arrival]:
    """Yield the messages of all topics in order of arrival."""
    came: Queue[Arrival] = Queue()
    subscribers = [node.subscriber(topic, None, _put(came, topic), queue_size=1000) for topic in topics]
    began, warned = time.monotonic(), False
    while True:
        try:
            # In short steps: Windows delivers no Ctrl-C during an endless wait.
            yield came.get(timeout=0.5 if timeout is None else min(timeout, 0.5))
            began, warned = time.monotonic(), True
        except Empty:
            silent = time.monotonic() - began
            if timeout is not None and silent >= timeout:
                raise RosTimeout(_silence(topics, subscribers, timeout)) from None
            if silent > PATIENCE and not warned and timeout is None:
                warn(_silence(topics, subscribers, PATIENCE) + "; still listening, Ctrl-C ends it")
                warned = True


def _put(came: Queue[Arrival], topic: str) -> Callable[[DynamicMessage], None]:
    return lambda message: came.put((topic, message, Time.from_sec(time.time())))


def _silence(topics: list[str], subscribers: list[Subscriber], seconds: float) -> str:
    connected = sum(subscriber.connections for subscriber in subscribers)
    if connected:
        who = f"{counted(connected, 'publisher')} connected"
    elif named := [subscriber for subscriber in subscribers if subscriber.stats()]:
        who = f"its publisher is not connected: {'; '.join(each.why_silent() for each in named)}"
    else:
        who = "nobody publishes it"
    return f"{', '.join(topics)}: no message within {seconds:g} s; {who}"


def _from_bag(arguments: argparse.Namespace, printer: _Printer) -> None:
    from rosproto.cli.bag_files import decodable, opened

    with opened(arguments.bag, arguments) as bag:
        topics = sorted(bag.topics)
        topic, path = split_topic(arguments.topic or "", topics)
        wanted = topics if arguments.all else [topic] if topic in topics else fnmatch.filter(topics, topic)
        if not wanted:
            raise CommandError(
                f"{arguments.bag} has no topic {topic!r}{near(topic, topics)}; "
                f"it has: {', '.join(topics) or 'none'}"
            )
        wanted = decodable(bag, wanted, arguments)
        if not wanted:
            return
        for name, message, stamp in bag.read_messages(topics=printer.choose(wanted, path, topics)):
            printer.show(name, message, stamp)
            if printer.done:
                return


class _Printer:
    """Prints messages in the selected form."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments = arguments
        self.filter = Expression(arguments.filter, ("m", "topic")) if arguments.filter else None
        since = Time.from_sec(time.time()) if arguments.offset else None
        self.view = ValueFilter(
            no_arrays=arguments.noarr, no_strings=arguments.nostr, since=since, columns=arguments.csv
        )
        self.take = parse_field_path("")
        self.several = False
        self.shown = 0
        self.missed = False
        self.drawn: list[tuple[str, Take]] = []  # topic, and the getter of the number
        self.curves: PlotSamples | None = None
        self.due = 0.0

    def choose(self, topics: list[str], path: str, known: list[str]) -> list[str]:
        """Select the topics and the field; return all topics to receive, with those of more --plot curves.

        Raises:
            ValueError: The path is malformed, or the form allows only one topic.
        """
        self.take = parse_field_path(path, f"{topics[0]}/{path}")
        self.several = len(topics) > 1
        if self.several and (self.arguments.csv or self.arguments.plot):
            raise ValueError(f"-p and --plot are for one topic, and these are {len(topics)}: name one")
        if not self.arguments.plot:
            return topics
        self.drawn = [(topics[0], self.take)]
        for asked in self.arguments.topics:
            topic, path = split_topic(absolute(asked), known)
            if topic not in known:
                warn(f"topic [{topic}] does not appear to be published yet{near(topic, known)}")
            self.drawn.append((topic, parse_field_path(path, f"{topic}/{path}")))
        seconds = self.arguments.seconds or (None if self.arguments.bag else 30.0)
        self.curves = PlotSamples([self.arguments.topic, *self.arguments.topics], seconds)
        return list(dict.fromkeys(topic for topic, _ in self.drawn))

    @property
    def done(self) -> bool:
        """Whether -n messages were shown."""
        return self.arguments.n is not None and self.shown >= self.arguments.n

    def show(self, topic: str, message: DynamicMessage, received: Time) -> None:
        """Print one message, if the filter accepts it."""
        if self.filter is not None and not self.filter(m=message, topic=topic):
            return
        if self.curves is not None:
            self.shown += 1
            self._plot(self.curves, topic, message, received)
            sys.stdout.flush()
            return
        try:
            value = self.take(message)
        except MissingElement as error:  # the next message may be longer
            if not self.missed:
                warn(f"{error}; messages without it are left out")
            self.missed = True
            return
        self.shown += 1
        if self.arguments.clear:
            clear(sys.stdout)
        if self.arguments.offset and not self.arguments.bag:
            self.view.since = Time.from_sec(time.time())
        if self.arguments.csv:
            self._csv(value, received)
        elif self.arguments.json:
            shown = plain(value)
            document = {"topic": topic, "message": shown} if self.several else shown
            self.arguments.out.record(document, is_plain=True)
        else:
            print(
                (f"# {printable(topic)}\n" if self.several and not self.arguments.all else "")
                + self._text(value)
                + "\n---"
            )
        sys.stdout.flush()

    def _text(self, value: object) -> str:
        return strify_message(self.view(value), width=self.arguments.width)

    def _csv(self, value: Any, received: Time) -> None:
        stamped = getattr(value, "_has_header", False) and not self.arguments.bag
        stamp = value.header.stamp if stamped else received
        value = self.view(value)
        if self.shown == 1:
            print("%time," + ",".join(header(value, "field")))
        since = self.view.since
        # Control characters and line ends are escaped: a message is one line.
        cells = ",".join(map(printable, row(value)))
        print(f"{stamp.to_nsec() - (since.to_nsec() if since else 0)},{cells}")

    def _plot(self, curves: PlotSamples, topic: str, message: DynamicMessage, received: Time) -> None:
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
            # Without colours, signs distinguish the curves.
            ascii_only=not shows_unicode(sys.stdout) or (len(titles) > 1 and not coloured),
            coloured=coloured and len(titles) > 1,
        )
        print("\n".join([*(title if coloured else title[: columns - 1] for title in titles), picture]))


COLOURS = ("36", "33", "32", "35", "31", "34")
SIGNS = "*+ox#@"
DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""Bits of a Braille cell (U+2800 block), by row and column."""
KEPT = 5000
"""Samples of each curve."""


class PlotSamples:
    """The newest samples of some numbers.

    Args:
        names: Names of the curves, in the order of the legend.
        seconds: Time span of the picture; None shows all samples.
    """

    def __init__(self, names: Sequence[str], seconds: float | None = 30.0) -> None:
        self.names = list(names)
        self._seconds = seconds
        self._samples: list[deque[tuple[float, float]]] = [deque(maxlen=KEPT) for _ in names]

    def add(self, index: int, moment: float, value: float) -> None:
        """Add a sample to a curve; `moment` in s."""
        samples = self._samples[index]
        if samples and moment < samples[-1][0]:
            samples.clear()  # a bag or clock restarted
        samples.append((moment, value))
        while self._seconds is not None and moment - samples[0][0] > self._seconds:
            samples.popleft()

    def legend(self, coloured: bool) -> list[str]:
        """Return a line per curve: its sign or colour, name and newest value."""
        lines = []
        for i, name in enumerate(self.names):
            value = f"{self._samples[i][-1][1]:.6g}" if self._samples[i] else "nothing yet"
            text = f"{SIGNS[i % len(SIGNS)]} {name}  {value}" if len(self.names) > 1 else f"{name}  {value}"
            lines.append(_in_colour(text, i) if coloured and len(self.names) > 1 else text)
        return lines

    def picture(self, width: int, height: int, *, ascii_only: bool = False, coloured: bool = False) -> str:
        """Draw the curves, with their range at the left and the time below.

        Args:
            width: Total columns.
            height: Total lines, with the axis.
            ascii_only: Signs instead of Braille dots.
            coloured: A colour per curve; otherwise only ASCII signs differ.
        """
        finite = [(t, v) for samples in self._samples for t, v in samples if math.isfinite(v)]
        if not finite:
            return "(no finite values yet)"
        low, high = min(v for _, v in finite), max(v for _, v in finite)
        newest = max(samples[-1][0] for samples in self._samples if samples)
        oldest = min(samples[0][0] for samples in self._samples if samples)
        if self._seconds is not None:
            oldest = max(oldest, newest - self._seconds)
        rows = max(1, height - 1)
        # The highest value labels the first row, the lowest the last.
        labels = [f"{high:.4g}", *[""] * (rows - 2), *([f"{low:.4g}"] if rows > 1 else [])]
        margin = max(map(len, labels))
        columns = max(8, width - margin - 2)
        grid = self._drawn(oldest, newest, low, high, columns, rows, ascii_only, coloured)
        bar = "|" if ascii_only else "┤"
        lines = [f"{label:>{margin}} {bar}{line}" for label, line in zip(labels, grid, strict=True)]
        return "\n".join([*lines, " " * (margin + 2) + _axis(newest - oldest, columns)])

    def _drawn(
        self, oldest: float, newest: float, low: float, high: float, columns: int, rows: int,
        ascii_only: bool, coloured: bool,
    ) -> list[str]:  # fmt: skip
        fine_x, fine_y = (1, 1) if ascii_only else (2, 4)
        span_t, span_v = (newest - oldest) or 1.0, (high - low) or 1.0
        cells: list[list[tuple[int, int]]] = [[(0, 0)] * columns for _ in range(rows)]  # bits, curve
        for index, samples in enumerate(self._samples):
            for moment, value in samples:
                if moment < oldest or not math.isfinite(value):
                    continue
                x = round((moment - oldest) / span_t * (columns * fine_x - 1))
                y = round((high - value) / span_v * (rows * fine_y - 1))
                row, column = y // fine_y, x // fine_x
                bit = 1 if ascii_only else DOTS[y % 4][x % 2]
                cells[row][column] = (cells[row][column][0] | bit, index)
        return ["".join(_cell(*cell, ascii_only, coloured) for cell in row).rstrip(" ") for row in cells]


def _cell(bits: int, index: int, ascii_only: bool, coloured: bool) -> str:
    sign = SIGNS[index % len(SIGNS)] if bits else " "
    text = sign if ascii_only else chr(0x2800 + bits)
    return _in_colour(text, index) if coloured and bits else text


def _in_colour(text: str, index: int) -> str:
    return f"\x1b[{COLOURS[index % len(COLOURS)]}m{text}\x1b[0m"


def _axis(seconds: float, columns: int) -> str:
    """`-30 s        -15 s        now`."""
    parts = max(1, min(4, columns // 14))
    line = [" "] * columns
    for i in range(parts + 1):
        text = "now" if i == parts else f"-{seconds * (parts - i) / parts:.3g} s"
        at = min(columns - len(text), max(0, round(i / parts * columns) - (len(text) if i == parts else 0)))
        line[at : at + len(text)] = text
    return "".join(line).rstrip()


class ValueFilter:
    """Converts a value as by --noarr, --nostr and --offset, without changing the original.

    Args:
        no_arrays: An array becomes `<array type: float32, length: 1080>`, as rostopic writes it.
        no_strings: A string becomes `<string length: 5>`.
        since: Times become durations since this time; None keeps them.
        columns: For CSV: arrays and strings are left out, without a text in their place.
    """

    def __init__(
        self,
        *,
        no_arrays: bool = False,
        no_strings: bool = False,
        since: Time | None = None,
        columns: bool = False,
    ) -> None:
        self._no_arrays = no_arrays
        self._no_strings = no_strings
        self._columns = columns
        self.since = since

    def __call__(self, value: object) -> object:
        """Return the value to print."""
        if isinstance(value, Time) and self.since is not None:
            return value - self.since
        if not (self._no_arrays or self._no_strings or self.since):
            return value
        if isinstance(value, list):  # of messages: /status/status_list
            return [self(item) for item in value]
        if not isinstance(value, Message):
            return value
        copy = object.__new__(type(value))
        for name, kind in zip(value.__slots__, value._slot_types, strict=True):
            setattr(copy, name, self._field(getattr(value, name), kind))
        return copy

    def _field(self, value: Any, kind: str) -> object:
        base, bracket, _ = kind.partition("[")
        if (bracket and self._no_arrays) or (base == "string" and self._no_strings):
            what = f"array type: {base}," if bracket else "string"
            return [] if self._columns else _PlainText(f"<{what} length: {len(value)}>")
        return self(value)


class _PlainText:
    """Text that prints as it is, without the quotes of a string."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __str__(self) -> str:
        return f'"{self._text}"'
