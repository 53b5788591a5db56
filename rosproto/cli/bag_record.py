"""`rosproto bag record`: the options of rosbag record."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from rosproto.cli.bag_progress import Progress
from rosproto.cli.console import counted
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import open_node
from rosproto.cli.graph_options import add_graph_options
from rosproto.cli.options import add_compression, count, positive, seconds, whole_from
from rosproto.cli.signals import interrupt_on_signals
from rosproto.sentence import Sentence, say
from rosproto.text import human_bytes

if TYPE_CHECKING:
    from rosproto.node import Node
    from rosproto.recording import Recorder, RecorderStats


MB = 1 << 20


def add_record_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the topics to record; see also `add_output_options`."""
    add_graph_options(parser, as_json=False)
    parser.add_argument("topics", nargs="*", metavar="TOPIC")
    parser.add_argument("-a", "--all", action="store_true", help="every topic, also those that appear later")
    parser.add_argument("-e", "--regex", action="store_true", help="TOPICs are regular expressions")
    parser.add_argument(
        "-x",
        "--exclude",
        action="append",
        default=[],
        metavar="REGEX",
        help="leave these out (repeat for more)",
    )
    parser.add_argument("--node", metavar="NAME", help="every topic that this node subscribes to")
    parser.add_argument("--tcpnodelay", action="store_true", help="ask publishers to send at once")
    parser.add_argument("--udp", action="store_true", help="take datagrams where publishers offer them")
    add_output_options(parser)


def add_output_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for output, format and duration."""
    parser.add_argument("-o", "--output-prefix", metavar="PREFIX", help="start of the name; the date follows")
    parser.add_argument("-O", "--output-name", metavar="NAME", help="use exactly this name")
    parser.add_argument("--force", action="store_true", help="replace a bag of that name")
    parser.add_argument("--split", action="store_true", help="start a new bag at --size or --duration")
    parser.add_argument("--max-splits", type=count, metavar="N", help="keep only the newest N")
    parser.add_argument("--size", type=positive, metavar="MB", help="end (or split) at this size")
    parser.add_argument(
        "--duration", type=seconds_of, metavar="SEC", help="end (or split) after this time: 30, 5m, 2h"
    )
    parser.add_argument("-l", "--limit", type=count, metavar="N", help="stop after N messages of each topic")
    parser.add_argument(
        "-b",
        "--buffsize",
        type=seconds,
        default=256,
        metavar="MB",
        help="limit of the data that waits for the disk (256)",
    )
    parser.add_argument(
        "--chunksize", type=whole_from(1, 1 << 20), default=768, metavar="KB", help="size of chunks (768)"
    )
    parser.add_argument(
        "--min-space", type=seconds, default=0, metavar="MB", help="end when less disk space is left"
    )
    parser.add_argument(
        "-p", "--publish", action="store_true", help="publish the name of each bag on /begin_write"
    )
    group = parser.add_mutually_exclusive_group()
    group.add_argument(
        "--repeat-latched", action="store_true", help="accepted for compatibility with rosbag; always on"
    )
    group.add_argument("--no-repeat-latched", action="store_true", help="do not repeat them in each split")
    parser.add_argument("-q", "--quiet", action="store_true", help="print no progress line")
    parser.add_argument(
        "--format", choices=("bag", "mcap"), help="format; default: by the ending of NAME, else bag"
    )
    add_compression(parser)


def seconds_of(text: str) -> float:
    """Convert 30, 30s, 5m or 2h to seconds."""
    found = re.fullmatch(r"([0-9]{1,9}(?:\.[0-9]{0,9})?)([smh]?)", text)
    if found is None or not float(found[1]) > 0:
        raise argparse.ArgumentTypeError(
            say("{text!r} is not a duration: write 30, 5m or 2h", text=text[:40])
        )
    return float(found[1]) * {"": 1, "s": 1, "m": 60, "h": 3600}[found[2]]


def recorder_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of `Recorder` for the options of `add_output_options`.

    Raises:
        CommandError: Contradictory options.
    """
    splits = arguments.split
    size = None if arguments.size is None else int(arguments.size * MB)
    if splits and size is None and arguments.duration is None:
        raise CommandError("--split needs --size, --duration, or both")
    if arguments.max_splits is not None and not splits:
        raise CommandError("--max-splits goes with --split")
    if arguments.output_name and arguments.output_prefix:
        raise CommandError("give -o or -O, not both")
    return {
        "path": arguments.output_name,
        "prefix": arguments.output_prefix or "",
        "overwrite": arguments.force,
        "compression": arguments.compression,
        "chunk_bytes": arguments.chunksize * 1024,
        "split_bytes": size if splits else None,
        "split_seconds": arguments.duration if splits else None,
        "max_bytes": None if splits else size,
        "max_seconds": None if splits else arguments.duration,
        "keep": arguments.max_splits,
        "repeat_latched": not arguments.no_repeat_latched,
        "limit": arguments.limit,
        "announce": arguments.publish,
        "form": arguments.format,
        "min_free_bytes": int(arguments.min_space * MB),
        "buffer_bytes": int(arguments.buffsize * MB) or 1 << 62,
    }


def record(arguments: argparse.Namespace) -> int:
    """Record until interrupted, or until a limit."""
    from rosproto.recording import Recorder, TopicSelection

    options = recorder_options(arguments)
    names, patterns = ((), arguments.topics) if arguments.regex else (arguments.topics, ())
    select = partial(TopicSelection, patterns=patterns, exclude=arguments.exclude, all=arguments.all)
    select(names, node=arguments.node)  # refuses a wrong pattern before the master is asked
    with interrupt_on_signals(), open_node(arguments, "record") as node:
        selection = select(
            [node.resolve_name(name) for name in names],
            node=node.resolve_name(arguments.node) if arguments.node else None,
        )
        _await_clock(node, arguments.quiet)
        transport = {"tcp_nodelay": arguments.tcpnodelay, "unreliable": arguments.udp}
        recorder = Recorder(node, selection=selection, **transport, **options)
        return follow_recording(recorder, quiet=arguments.quiet)


def _await_clock(node: Node, quiet: bool) -> None:
    """With simulated time, wait for the first time: earlier messages would be stamped 0."""
    if node.clock.wait_for_time(0.5):
        return
    if not quiet:
        print("waiting for /clock (/use_sim_time is set)", file=sys.stderr, flush=True)
    while not node.clock.wait_for_time(0.5):
        pass


def follow_recording(
    recorder: Recorder, *, quiet: bool = False, translate: Callable[[str], str] = str
) -> int:
    """Show progress until the recording ends or is interrupted, then finish; return 1 if messages were lost.

    The progress line is overwritten on a terminal, and printed every ten seconds in a log.

    Raises:
        BagError: Writing failed.
    """
    line = Progress("", quiet=quiet)
    shown: RecorderStats | None = None

    def note(template: str, **values: object) -> None:
        line.note(translate(say(template, **values)))

    try:
        note("recording to {path}", path=recorder.stats().path)
        while not recorder.wait(0.5):
            stats = recorder.stats()
            if line.on or stats.seconds - (shown.seconds if shown else 0.0) >= 10.0:
                (line.show if line.on else line.note)(translate(progress_line(stats, shown)))
                shown = stats
    except KeyboardInterrupt:
        pass  # the normal end of a recording
    finally:
        line.leave()
        try:
            recorder.close()
        finally:
            stats = recorder.stats()
            for path in recorder.paths:
                note("{path}" if path.exists() else "{path}.active (not finished)", path=path)
            note(
                "{messages}, {size}, {seconds:.1f} s, {dropped} dropped",
                messages=counted(stats.messages, "message"),
                size=human_bytes(stats.bytes),
                seconds=stats.seconds,
                dropped=stats.dropped,
            )
            if not stats.messages:
                note("nothing came: did anybody publish these topics? see: rosproto topic list")
    return 1 if recorder.dropped else 0


def progress_line(stats: RecorderStats, before: RecorderStats | None) -> Sentence:
    """Return the progress line; `before` is what the previous line showed."""
    rate = "-"
    if before is not None and stats.seconds > before.seconds:
        rate = human_bytes(max(0, stats.bytes - before.bytes) / (stats.seconds - before.seconds))
    text = say(
        "{seconds:.0f} s  {messages}  {topics}  {size}  {rate}/s",
        seconds=stats.seconds,
        messages=counted(stats.messages, "message"),
        topics=counted(stats.topics, "topic"),
        size=human_bytes(stats.bytes),
        rate=rate,
    )
    if stats.waiting_bytes > 8 * MB:
        text = say("{text}  {size} wait for the disk", text=text, size=human_bytes(stats.waiting_bytes))
    return say("{text}  {dropped} DROPPED", text=text, dropped=stats.dropped) if stats.dropped else text
