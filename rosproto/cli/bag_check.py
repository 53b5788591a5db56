"""`rosproto bag check`: read and decode every message, and report problems."""

from __future__ import annotations

import argparse
from collections import Counter

from rosproto.bag import BagReader
from rosproto.codec import Message, decode
from rosproto.errors import BagError, CodecError, DefinitionError
from rosproto.msg import bundled
from rosproto.text import printable

from .bag_opening import reader_of
from .bag_progress import Progress
from .console import counted, print_json
from .options import add_json


def add_check_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the bags and the report options."""
    parser.add_argument("bags", nargs="+", metavar="BAG")
    add_json(parser)
    parser.add_argument("-q", "--quiet", action="store_true", help="print problems only")


def check(arguments: argparse.Namespace) -> int:
    """Check each bag; return 0 if all are sound, else 1."""
    bad = 0
    for path in arguments.bags:
        with reader_of(path, skip_damaged=True, quiet=arguments.quiet) as bag:
            problems = problems_of(bag, quiet=arguments.quiet)
            notes = _notes(bag)
        bad += bool(problems)
        if arguments.json:
            print_json({"path": path, "messages": bag.message_count, "problems": problems, "notes": notes})
            continue
        for line in problems:
            print(printable(f"{path}: {line}"))
        if not arguments.quiet:
            for line in notes:
                print(printable(f"{path}: note: {line}"))
            print(f"{path}: {'NOT sound' if problems else 'sound'}, {counted(bag.message_count, 'message')}")
    return 1 if bad else 0


def problems_of(bag: BagReader, *, quiet: bool = True) -> list[str]:
    """Read and decode a whole bag, and return a sentence for each problem."""

    problems: list[str] = []
    classes = {number: cls for number in bag.connections if (cls := _class_of(bag, number, problems))}
    known = [bag.connections[number] for number in classes]
    first: dict[int, str] = {}
    failed: Counter[int] = Counter()
    with Progress(f"checking {bag.path}", bag.message_count, quiet=quiet) as progress:
        for _, raw, _ in bag.read_messages(raw=True, connections=known):
            number = raw.connection.id
            try:
                decode(classes[number], raw.data)
            except CodecError as problem:
                failed[number] += 1
                first.setdefault(number, str(problem))
            progress.step()
    for number, count in failed.items():
        problems.append(
            f"{bag.connections[number].topic}: {counted(count, 'message')} cannot be decoded, "
            f"the first: {first[number]}"
        )
    return [*bag.damage, *problems]


def _class_of(bag: BagReader, number: int, problems: list[str]) -> type[Message] | None:
    try:
        return bag.message_class(bag.connections[number])
    except BagError as problem:
        problems.append(str(problem))
        return None


def _notes(bag: BagReader) -> list[str]:
    """Return notes without damage: stored definitions that differ from the present ones."""

    notes = []
    for kind, md5sum in sorted({(c.type, c.md5sum) for c in bag.connections.values()}):
        try:
            present = bundled().md5sum(kind)
        except DefinitionError:
            notes.append(f"{kind} is not bundled here; the definition in the bag is used")
            continue
        if present != md5sum:
            notes.append(f"{kind} was recorded as another revision ({md5sum}, the bundled one is {present})")
    return notes
