"""`rosproto topic hz|delay|bw`: rate, delay and bandwidth over a window of messages."""

from __future__ import annotations

import argparse
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rosproto.cli.console import warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.expression import Expression
from rosproto.cli.graph_clients import absolute, below, master_client, open_node
from rosproto.cli.options import count
from rosproto.cli.parser import near
from rosproto.rates import Bandwidth, Statistics, Window, bandwidth_text, delay_text, hz_table, hz_text

if TYPE_CHECKING:
    from rosproto.codec import DynamicMessage


def add_hz_arguments(parser: argparse.ArgumentParser) -> None:
    """Add topics, window and filter."""
    _common(parser, 50_000)
    parser.add_argument("--filter", metavar="EXPRESSION", help="only messages for which it is true")
    parser.add_argument(
        "--tcpnodelay", action="store_true", help="ask publishers to send without Nagle's delay"
    )


def add_bw_arguments(parser: argparse.ArgumentParser) -> None:
    """Add topics and window."""
    _common(parser, 100)


def _common(parser: argparse.ArgumentParser, window: int) -> None:
    parser.add_argument("topic", nargs="+", help="one or several, or a pattern: '/scan*'")
    parser.add_argument(
        "-w", "--window", type=count, default=window, metavar="N", help=f"messages looked at ({window})"
    )
    parser.add_argument("-n", type=count, default=None, metavar="COUNT", help="stop after this many reports")
    parser.add_argument(
        "--wall-time", action="store_true", help="accepted for compatibility with rostopic; always on"
    )


def run_hz(arguments: argparse.Namespace) -> None:
    """Print the intervals between arrivals every second."""
    wanted = Expression(arguments.filter) if arguments.filter else None
    windows = _windows(arguments)

    def arrived(topic: str, message: DynamicMessage, now: float) -> None:
        if wanted is None or wanted(m=message):
            windows[topic].add(now)

    def report() -> None:
        if arguments.json:
            arguments.out.record({t: _figures(w.statistics(), "interval") for t, w in windows.items()})
            return
        found = {topic: window.news() for topic, window in windows.items()}
        print(hz_text(*found.values()) if len(found) == 1 else hz_table(found), flush=True)

    _watch(arguments, arrived, report, raw=wanted is None)


def _windows(arguments: argparse.Namespace) -> dict[str, Window]:
    """Return a window per topic; a single message gives no interval or delay."""
    return {topic: Window(max(2, arguments.window)) for topic in _topics(arguments)}


def _figures(found: Statistics | None, what: str) -> dict[str, float] | None:
    if found is None:
        return None
    figures = {f"mean_{what}": found.mean, f"min_{what}": found.minimum, f"max_{what}": found.maximum}
    figures |= {"std_dev": found.deviation, "count": found.messages - 1}
    if what == "interval" and found.mean > 0:
        figures["rate"] = found.rate
    return figures


def run_delay(arguments: argparse.Namespace) -> None:
    """Print arrival time minus header stamp; the clocks must be synchronized."""
    wanted = Expression(arguments.filter) if arguments.filter else None
    windows = _windows(arguments)
    headless: list[str] = []

    def arrived(topic: str, message: DynamicMessage, now: float) -> None:
        if not message._has_header:
            headless.append(f"{topic} ({message._type})")
        elif wanted is None or wanted(m=message):
            windows[topic].add(now, time.time() - message.header.stamp.to_sec())

    def report() -> None:
        if headless:
            raise CommandError(f"{headless[0]} has no header, so its messages do not say when they were made")
        if arguments.json:
            arguments.out.record({t: _figures(w.statistics(), "delay") for t, w in windows.items()})
            return
        for topic, window in windows.items():
            if window.values:
                text = delay_text(window.news())
                print(text if len(windows) == 1 else f"{topic}: {text}", flush=True)

    _watch(arguments, arrived, report, raw=False)


def run_bw(arguments: argparse.Namespace) -> None:
    """Print the bytes per second, every second."""
    bandwidths = {topic: Bandwidth(max(2, arguments.window)) for topic in _topics(arguments)}

    def arrived(topic: str, message: DynamicMessage, now: float) -> None:
        bandwidths[topic].add(now, len(message._buff))

    def report() -> None:
        now = time.monotonic()
        if arguments.json:
            arguments.out.record(
                {t: {"bytes_per_second": b.per_second(now), "sizes": b.sizes} for t, b in bandwidths.items()}
            )
            return
        for topic, bandwidth in bandwidths.items():
            text = bandwidth_text(bandwidth, now)
            if text is not None:
                print(text if len(bandwidths) == 1 else f"{topic}: {text}", flush=True)

    _watch(arguments, arrived, report, raw=True)


def _topics(arguments: argparse.Namespace) -> list[str]:
    """Return the global names with patterns resolved; warn about topics without publishers."""
    with master_client(arguments) as master:
        published = list(master.get_system_state().publishers)
    found: list[str] = []
    for asked in arguments.topic:
        if "*" in asked or "?" in asked:
            matching = below(published, asked)
            if not matching:
                raise CommandError(f"no topic matches {asked!r}; see: rosproto topic list")
            found += matching
        else:
            found.append(absolute(asked))
            if found[-1] not in published:
                warn(f"topic [{found[-1]}] does not appear to be published yet{near(found[-1], published)}")
    arguments.topic = list(dict.fromkeys(found))
    return found


def _watch(
    arguments: argparse.Namespace,
    arrived: Callable[[str, DynamicMessage, float], None],
    report: Callable[[], None],
    *,
    raw: bool,
) -> None:
    """Subscribe to all topics and report every second until interrupted."""
    lock = threading.Lock()
    problems: list[Exception] = []

    def callback_for(topic: str) -> Callable[[DynamicMessage], None]:
        def callback(message: DynamicMessage) -> None:
            now = time.monotonic()
            try:
                with lock:
                    arrived(topic, message, now)
            except ValueError as error:  # the filter does not match the message: the main thread reports it
                problems.append(error)

        return callback

    with open_node(arguments) as node:
        for topic in arguments.topic:
            node.subscriber(
                topic, None, callback_for(topic), raw=raw, queue_size=10_000,
                tcp_nodelay=getattr(arguments, "tcpnodelay", False),
            )  # fmt: skip
            if not arguments.json:
                print(f"subscribed to [{topic}]", flush=True)
        reports = 0
        while arguments.n is None or reports < arguments.n:
            time.sleep(1.0)
            if problems:
                raise problems[0]
            with lock:
                report()
            reports += 1
