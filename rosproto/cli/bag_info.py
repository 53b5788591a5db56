"""`rosproto bag info`: the output of `rosbag info`, with a curve of each topic's rate.

It reads only the index. Text and YAML equal rosbag's; the curves are appended to the lines; --plain omits
them.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable

from rosproto.bag import BagReader
from rosproto.bag.summary import Facts, facts, text, yaml, yaml_value
from rosproto.cli.bag_files import reader_of
from rosproto.cli.bag_progress import Progress
from rosproto.cli.console import shows_unicode
from rosproto.cli.exit_codes import CommandError
from rosproto.text import printable

CURVE = 24  # characters
FINE = 16  # minimum chunks per part to treat a chunk as one moment


def add_info_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of rosbag info, and our own."""
    parser.add_argument("bags", nargs="+", metavar="BAG")
    parser.add_argument("-y", "--yaml", action="store_true", help="print YAML, as rosbag does")
    parser.add_argument("-k", "--key", help="print only this (with --yaml)")
    parser.add_argument("--json", action="store_true", help="print JSON, one line per bag")
    parser.add_argument("--freq", action="store_true", help="also the median rate of each topic")
    parser.add_argument("--plain", action="store_true", help="exactly what rosbag info prints: no curves")


def info(arguments: argparse.Namespace) -> None:
    """Print the contents of each bag."""
    if arguments.key and not arguments.yaml:
        raise CommandError("--key chooses a part of the YAML: add --yaml")

    for number, path in enumerate(arguments.bags):
        if number and not arguments.json:
            print("---")
        with reader_of(path) as bag:
            drawn = not (arguments.yaml or arguments.plain) or arguments.json
            with Progress(f"reading {path}", _steps(bag, arguments.freq, drawn)) as progress:
                found = facts(bag, freq=arguments.freq, step=progress.step)
                counts = _counts(bag, progress.step) if drawn else {}
            if arguments.json:
                arguments.out.record(found | {"curves": counts})
            elif arguments.yaml:
                print(_yaml(found, arguments.key))
            else:
                print(text(found, _curves(counts)))
            for problem in bag.damage:
                print(printable(f"rosproto bag info: {path}: {problem}"), file=sys.stderr)


def _yaml(found: Facts, key: str | None) -> str:
    if key is None:
        return yaml(found)
    try:
        return yaml_value(found, key)
    except KeyError as error:
        raise CommandError(f"--key {key}: there is {error.args[0]}") from None


def _steps(bag: BagReader, freq: bool, drawn: bool) -> int:
    """Number of progress steps: one per chunk, and one per topic in each chunk."""
    topics = {number: connection.topic for number, connection in bag.connections.items()}
    times = sum(len({topics[n] for n in chunk.counts if n in topics}) for chunk in bag.chunks)
    return len(bag.chunks) + times * (freq + (drawn and not _told_by_chunks(bag)))


# -- curves ------------------------------------------------------------------------------------------------


def _counts(bag: BagReader, step: Callable[[], None]) -> dict[str, list[int]]:
    """Count each topic's messages in each of `CURVE` equal parts of the bag's time, without reading messages.

    It uses the counts of the chunks if these are much shorter than a part, as in large bags; otherwise the
    times in the index records.
    """
    if bag.start_time is None or bag.end_time is None:
        return {}
    start, end = bag.start_time.to_nsec(), bag.end_time.to_nsec() + 1
    if _told_by_chunks(bag):
        return _counts_by_chunk(bag, start, end)
    import numpy as np

    edges = np.linspace(start, end, CURVE + 1)
    found: dict[str, list[int]] = {}
    for topic in bag.topics:
        found[topic] = np.histogram(bag.times(topic, step=step), edges)[0].tolist()
    return found


def _told_by_chunks(bag: BagReader) -> bool:
    if bag.start_time is None or bag.end_time is None:
        return True
    length = bag.end_time.to_nsec() + 1 - bag.start_time.to_nsec()
    return all(FINE * CURVE * (chunk.end - chunk.start) <= length for chunk in bag.chunks)


def _counts_by_chunk(bag: BagReader, start: int, end: int) -> dict[str, list[int]]:
    found = {topic: [0] * CURVE for topic in bag.topics}
    rows = {number: found[connection.topic] for number, connection in bag.connections.items()}
    for chunk in bag.chunks:
        part = ((chunk.start + chunk.end) // 2 - start) * CURVE // (end - start)
        for number, count in chunk.counts.items():
            if count:
                rows[number][part] += count
    return found


BARS, ASCII_BARS = "▁▂▃▄▅▆▇█", "_.-=+*%#"


def _curves(found: dict[str, list[int]]) -> dict[str, str]:
    bars = BARS if shows_unicode(sys.stdout) else ASCII_BARS
    return {printable(topic): curve(counts, bars) for topic, counts in found.items()}


def curve(counts: list[int], bars: str = BARS) -> str:
    """Draw one character for each number, from zero: a constant rate is a line of full height."""
    top = max(counts) or 1
    return "".join(bars[round(count / top * (len(bars) - 1))] for count in counts)
