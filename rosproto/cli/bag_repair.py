"""`rosproto bag check`, `reindex` and `fix`: find damage, and repair bags after a crash or a bad copy."""

from __future__ import annotations

import argparse
import os
from collections import Counter

from rosproto.bag import BagReader, recover
from rosproto.bag import reindex as mend
from rosproto.cli.bag_files import check_local, check_new, compression_of, reader_of, whole
from rosproto.cli.bag_progress import Progress
from rosproto.cli.console import counted
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.options import add_compression, add_json, add_quiet
from rosproto.codec import Message, decode
from rosproto.errors import BagError, CodecError, DefinitionError
from rosproto.files import replace_file
from rosproto.msg import bundled
from rosproto.text import printable


def add_reindex_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the bags and the output folder."""
    parser.add_argument(
        "bags", nargs="+", metavar="BAG", help="also the .bag.active of a recorder that crashed"
    )
    parser.add_argument("--output-dir", metavar="DIR", help="repair a copy there; the bags are not changed")
    parser.add_argument("-f", "--force", action="store_true", help="replace existing files")
    add_quiet(parser)


def reindex(arguments: argparse.Namespace) -> None:
    """Repair each bag in place or as a copy; an .active file gets its final name."""
    for path in arguments.bags:
        check_local(path, "rosproto bag fix URL NEW.bag writes a new bag of what is there")
        if arguments.output_dir:
            path = _copied(path, arguments.output_dir, arguments.force, arguments.quiet)
        with Progress(f"mending {path}", quiet=arguments.quiet, in_bytes=True) as progress:
            report = mend(path, scanning=progress.at)
        final = path.removesuffix(".active")
        if final != path and (arguments.force or not os.path.exists(final)):
            replace_file(path, final)
        else:
            final = path
        if arguments.quiet:
            continue
        for line in report.damage:
            print(printable(f"{final}: was: {line}"))
        state = "has an index now" if report.damage else "is sound, nothing was changed"
        print(f"{final}: {state}; {counted(report.messages, 'message')}")


def _copied(path: str, folder: str, force: bool, quiet: bool) -> str:
    """Copy a bag for repair and return the path."""
    output = os.path.join(folder, os.path.basename(path))
    if os.path.realpath(output) == os.path.realpath(path):
        raise CommandError(f"{output} is the input; choose another directory")
    if not force and any(os.path.exists(name) for name in (output, output.removesuffix(".active"))):
        raise CommandError(f"{output} already exists; remove it, or use --force")
    try:
        _copy(path, output, quiet)
    except OSError as problem:
        raise CommandError(f"{path} cannot be copied to {output}: {problem.strerror}") from problem
    return output


def _copy(path: str, output: str, quiet: bool) -> None:
    with (
        open(path, "rb") as old,
        open(output, "wb") as new,
        Progress(f"copying {path}", os.path.getsize(path), quiet=quiet, in_bytes=True) as progress,
    ):
        while block := old.read(1 << 20):
            new.write(block)
            progress.step(len(block))


def add_fix_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the input and the output."""
    parser.add_argument("bag", metavar="DAMAGED", help="the damaged bag, which is not changed")
    parser.add_argument("output", metavar="OUTPUT", help="the new bag")
    add_compression(parser)


def fix(arguments: argparse.Namespace) -> None:
    """Write every readable message into a new bag."""
    check_new([arguments.output], arguments.bag)
    with whole(arguments.output), Progress(f"opening {arguments.bag}", in_bytes=True) as progress:
        report = recover(
            arguments.bag,
            arguments.output,
            compression=compression_of(arguments),
            progress=progress.at,
            found=lambda count: progress.go_on(f"saving {arguments.bag}", count),
            scanning=progress.at,
        )
    for line in report.damage:
        print(printable(f"{arguments.bag}: {line}"))
    print(f"{arguments.output}: {counted(report.messages, 'message')}")


# -- check --------------------------------------------------------------------------------------------------


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
            arguments.out.record(
                {"path": path, "messages": bag.message_count, "problems": problems, "notes": notes}
            )
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
    return [*bag.damage, *bag.index_damage(), *problems]


def _class_of(bag: BagReader, number: int, problems: list[str]) -> type[Message] | None:
    try:
        return bag.message_class(bag.connections[number])
    except BagError as problem:
        problems.append(str(problem))
        return None


def _notes(bag: BagReader) -> list[str]:
    """Return notes without damage: ignored bytes, and definitions that differ from the present ones."""
    notes = []
    if bag.trailing_bytes:
        notes.append(
            f"{counted(bag.trailing_bytes, 'byte')} behind its index do not belong to it and are ignored"
        )
    usable = {c.type for c in bag.connections.values() if _class_of(bag, c.id, [])}
    for kind, md5sum in sorted({(c.type, c.md5sum) for c in bag.connections.values()}):
        try:
            present = bundled().md5sum(kind)
        except DefinitionError:
            if kind in usable:
                notes.append(f"{kind} is not bundled here; the definition in the bag is used")
            continue
        if present != md5sum:
            notes.append(f"{kind} was recorded as another revision ({md5sum}, the bundled one is {present})")
    return notes
