"""`rosproto bag filter`, `merge`, `compress`, `decompress`: write new bags with unchanged messages."""

from __future__ import annotations

import argparse
import heapq
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from rosproto.bag import BagReader, RawMessage, create_bag
from rosproto.cli.bag_files import (
    Compression,
    check_local,
    check_new,
    compression_of,
    left_out,
    opened,
    whole,
)
from rosproto.cli.bag_progress import Progress
from rosproto.cli.console import counted
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.expression import Expression, ExpressionError
from rosproto.cli.options import add_allow_damaged, add_compression, add_quiet, seconds
from rosproto.codec import AnyMsg, decode
from rosproto.errors import BagError
from rosproto.files import replace_file
from rosproto.text import human_bytes
from rosproto.time import Time

if TYPE_CHECKING:
    from rosproto.codec import Message

Entry = tuple[str, "RawMessage", "Time"]
NAMES = ("m", "topic", "t")  # of an expression


def add_span_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options for topics and time span."""
    parser.add_argument("--topics", nargs="+", metavar="TOPIC", help="only these; patterns such as '/cam/*'")
    parser.add_argument("--exclude", nargs="+", metavar="TOPIC", default=[], help="leave these out")
    parser.add_argument(
        "-s", "--start", type=seconds, default=None, metavar="SEC", help="skip this many seconds at the start"
    )
    parser.add_argument(
        "-u", "--duration", type=seconds, default=None, metavar="SEC", help="take only this many seconds"
    )


def wanted_topics(bag: BagReader, arguments: argparse.Namespace) -> list[str]:
    """Return the bag's topics that the options select.

    Raises:
        CommandError: No topic is selected.
    """
    patterns = arguments.topics or ["*"]
    chosen = [
        topic
        for topic in bag.topics
        if any(fnmatchcase(topic, p) for p in patterns)
        and not any(fnmatchcase(topic, p) for p in arguments.exclude)
    ]
    if not chosen and bag.topics:
        raise CommandError(f"{bag.path}: no such topic; there are {', '.join(bag.topics)}")
    return chosen


def span(bag: BagReader, arguments: argparse.Namespace) -> tuple[Time | None, Time | None]:
    """Return the first and last selected time; None means no limit."""
    if bag.start_time is None or (arguments.start is None and arguments.duration is None):
        return None, None
    start = bag.start_time.to_nsec() + round((arguments.start or 0.0) * 1e9)
    end = None if arguments.duration is None else start + round(arguments.duration * 1e9)
    return Time(*divmod(start, 10**9)), None if end is None else Time(*divmod(end, 10**9))


# -- filter ------------------------------------------------------------------------------------------------


def add_filter_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of rosbag filter, and options that replace expressions."""
    parser.add_argument("bag", metavar="IN")
    parser.add_argument("output", metavar="OUT")
    parser.add_argument(
        "expression",
        nargs="?",
        help="only messages for which it is true; m: the message, topic, t: the receive time "
        "(t.secs, t.nsecs, t.to_sec()): \"topic == '/odom' and m.twist.twist.linear.x > 0\"",
    )
    parser.add_argument(
        "-p", "--print", dest="shown", metavar="EXPRESSION", help="print its value for each message examined"
    )
    add_span_arguments(parser)
    add_allow_damaged(parser)
    add_compression(parser)


def filter(arguments: argparse.Namespace) -> None:
    """Copy the selected messages."""
    rule = Expression(arguments.expression, NAMES) if arguments.expression else None
    shown = Expression(arguments.shown, NAMES) if arguments.shown else None
    check_new([arguments.output], arguments.bag)
    with opened(arguments.bag, arguments) as bag:
        topics = wanted_topics(bag, arguments)
        start, end = span(bag, arguments)
        entries = bag.read_messages(topics, start, end, raw=True)
        keep = None if rule is None and shown is None else _message_filter(bag, rule, shown, arguments)
        total, quiet = bag.message_count, shown is not None  # printed text would break the progress line
        kept = write(arguments.output, entries, compression_of(arguments), total, keep, quiet=quiet)
    print(f"{arguments.output}: {kept} of {counted(bag.message_count, 'message')}")


def _message_filter(
    bag: BagReader, rule: Expression | None, shown: Expression | None, arguments: argparse.Namespace
) -> Callable[[str, RawMessage, Time], bool]:
    """Return what evaluates the expressions on each decoded message; kept messages are written unchanged.

    Messages without a usable definition have no fields. Where an expression asks for one, they are left out.
    """
    classes: dict[int, type[Message]] = {}
    problems: dict[int, str] = {}
    reported: set[int] = set()

    def keep(topic: str, raw: RawMessage, stamp: Time) -> bool:
        number = raw.connection.id
        if number not in classes:
            try:
                classes[number] = bag.message_class(raw.connection)
            except BagError as problem:
                classes[number], problems[number] = AnyMsg, str(problem)
        message = decode(classes[number], raw.data)
        try:
            wanted = rule is None or bool(rule(m=message, topic=topic, t=stamp))
            if shown is not None:
                print("MATCH" if wanted else "NO MATCH", shown(m=message, topic=topic, t=stamp))
        except ExpressionError:
            if number not in problems:
                raise
            if number not in reported:
                reported.add(number)
                left_out(problems[number], arguments)
            return False
        return wanted

    return keep


# -- merge -------------------------------------------------------------------------------------------------


def add_merge_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; the new bag comes first, so that patterns can follow."""
    parser.add_argument("output", metavar="OUT")
    parser.add_argument("bags", nargs="+", metavar="IN")
    add_allow_damaged(parser)
    add_compression(parser)


def merge(arguments: argparse.Namespace) -> None:
    """Merge the messages of several bags, sorted by receive time."""
    check_new([arguments.output], *arguments.bags)
    with ExitStack() as stack:
        bags = [stack.enter_context(opened(path, arguments)) for path in arguments.bags]
        streams = [bag.read_messages(raw=True) for bag in bags]
        entries = heapq.merge(*streams, key=lambda entry: (entry[2].secs, entry[2].nsecs))
        total = sum(bag.message_count for bag in bags)
        count = write(arguments.output, entries, compression_of(arguments), total)
    print(f"{arguments.output}: {counted(count, 'message')} of {counted(len(bags), 'bag')}")


# -- convert -----------------------------------------------------------------------------------------------


def add_convert_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the input and the output; the output's ending selects the format."""
    parser.add_argument("bag", metavar="IN")
    parser.add_argument(
        "output",
        metavar="OUT",
        help="NAME.mcap (by zstd unless --lz4 is given) or NAME.bag; with --ros2 a directory",
    )
    parser.add_argument(
        "--ros2", action="store_true", help="write a ROS 2 bag (SQLite), with the package rosbags"
    )
    add_allow_damaged(parser)
    add_quiet(parser)
    add_compression(parser)


def convert(arguments: argparse.Namespace) -> None:
    """Write the same messages, times, topics and connection headers in the other format."""
    if arguments.ros2 and arguments.compression != "none":
        raise CommandError("--ros2 writes without compression: omit -j and --lz4")
    if not arguments.ros2 and not arguments.output.lower().endswith((".mcap", ".bag")):
        raise CommandError(f"{arguments.output}: the name must end in .mcap or .bag for the format")
    check_new([arguments.output], arguments.bag)
    quiet = arguments.quiet
    with opened(arguments.bag, arguments, quiet=quiet) as bag:
        if arguments.ros2:
            from rosproto.bag.ros2 import write_ros2

            with Progress(arguments.output, bag.message_count, quiet=quiet) as progress:
                count = write_ros2(bag, arguments.output, progress.step)
        else:
            entries, total = bag.read_messages(raw=True), bag.message_count
            count = write(arguments.output, entries, compression_of(arguments), total, quiet=quiet)
    if not quiet:
        print(f"{arguments.output}: {counted(count, 'message')}")


# -- compress and decompress -------------------------------------------------------------------------------


def add_compress_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of rosbag compress."""
    _in_place_arguments(parser)
    add_compression(parser, default="bz2")


def add_decompress_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of rosbag decompress."""
    _in_place_arguments(parser)
    parser.set_defaults(compression="none")


def _in_place_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("bags", nargs="+", metavar="BAG")
    parser.add_argument(
        "--output-dir", metavar="DIR", help="write to this directory (created if needed) and keep the bags"
    )
    parser.add_argument("-f", "--force", action="store_true", help="replace an older NAME.orig.bag")
    add_allow_damaged(parser)
    add_quiet(parser)


def compress(arguments: argparse.Namespace) -> None:
    """Rewrite each bag; without --output-dir the original becomes NAME.orig.bag."""
    for path in arguments.bags:
        _rewrite(path, arguments)


decompress = compress


def _rewrite(path: str, arguments: argparse.Namespace) -> None:
    check_local(path, "rosproto bag filter writes a new bag of it, compressed with -j or --lz4")
    base, extension = os.path.splitext(path)
    backup = f"{base}.orig{extension}"
    if arguments.output_dir:
        os.makedirs(arguments.output_dir, exist_ok=True)
        output = os.path.join(arguments.output_dir, os.path.basename(path))
        check_new([output], path)
    else:
        output = f"{path}.new"
        if os.path.exists(backup) and not arguments.force:
            raise CommandError(f"{backup} already exists: an older original; remove it, or use --force")
    quiet = arguments.quiet
    with opened(path, arguments, quiet=quiet, bags_only=True) as bag:
        entries = bag.read_messages(raw=True)
        write(output, entries, arguments.compression, bag.message_count, quiet=quiet, what=path)
        before = bag.size
    after = os.path.getsize(output)
    if not arguments.output_dir:
        with whole(output):
            replace_file(path, backup)
            replace_file(output, path)
    if not arguments.quiet:
        print(f"{path}: {human_bytes(before)} -> {human_bytes(after)} ({100 * after / before:.0f} %)")


# -- writing -----------------------------------------------------------------------------------------------


def write(
    output: str,
    entries: Iterator[Entry],
    compression: Compression,
    total: int,
    keep: Callable[[str, RawMessage, Time], bool] | None = None,
    *,
    mcap: bool | None = None,
    quiet: bool = False,
    what: str = "",
) -> int:
    """Write messages into a new bag or MCAP file (`create_bag`), and return their number."""
    with (
        whole(output),
        create_bag(output, compression, mcap=mcap) as writer,
        Progress(what or output, total, quiet=quiet) as progress,
    ):
        add, step = writer.write, progress.step
        for topic, message, stamp in entries:
            if keep is None or keep(topic, message, stamp):
                add(topic, message, stamp)
            step()
        return writer.message_count
