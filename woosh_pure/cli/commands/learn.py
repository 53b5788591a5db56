"""`woosh learn`: compare the robot's message definitions, and save new ones."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.cli import count, positive
from rosproto.msg import environment_paths, learned_paths, revisions_folder
from rosproto.sentence import say
from woosh_pure.cli.connection import graph_of, names, reaching
from woosh_pure.cli.output import Output

if TYPE_CHECKING:
    from woosh_pure.firmware.learn import Comparison


_WORDS = {
    "bundled": "as bundled",
    "revision": "known revision",
    "folder": "known",
    "new": "NEW",
    "unknown": "NOT KNOWN",
    "unusable": "NOT USABLE",
    "silent": "no answer",
}


def add_learn(parser: ArgumentParser) -> None:
    parser.add_argument("--dry-run", action="store_true", help="write nothing")
    parser.add_argument("--all", action="store_true", help="also list what does not differ")
    parser.add_argument("--timeout", type=positive, default=30.0, metavar="S", help="in all (default 30)")
    parser.add_argument(
        "--parallel", type=count, default=8, metavar="N", help="requests in parallel (default 8)"
    )
    parser.add_argument("--folder", type=Path, help="save there instead of in your revisions folder")


def run_learn(args: Namespace, out: Output) -> int:
    from rosproto import Node
    from woosh_pure.firmware.learn import KnownDefinitions, compare
    from woosh_pure.firmware.survey import survey

    folder = args.folder or revisions_folder()
    with ExitStack() as stack:
        uri, host = graph_of(args, out, stack)
        with reaching():
            node = stack.enter_context(
                Node(
                    "woosh_learn",
                    master_uri=uri,
                    host=host,
                    anonymous=True,
                    rosout=False,
                    resolve=names(args),
                )
            )
        answers = survey(node, timeout=args.timeout, parallel=args.parallel)
        learned = () if args.no_learned else learned_paths(folder)
        known_definitions = KnownDefinitions(
            [*learned, *map(Path, args.msg_path or ()), *map(Path, environment_paths())]
        )
        comparisons = [compare(answer, known_definitions) for answer in answers]
    _print(comparisons, out, everything=args.all)
    skipped: list[str] = []
    written = _keep(comparisons, folder, uri, out, skipped, dry=args.dry_run)
    out.result(
        {
            "master_uri": uri,
            "folder": str(folder),
            "written": [str(path) for path in written],
            "skipped": skipped,
            "findings": [_document(comparison) for comparison in comparisons],
        }
    )
    return 0 if any(comparison.verdict != "silent" for comparison in comparisons) else 1


def _print(comparisons: list[Comparison], out: Output, *, everything: bool) -> None:
    """Print a line per topic and service, with its differences below; each type's differences once."""
    shown: set[tuple[str, str]] = set()
    for comparison in comparisons:
        answer = comparison.answer
        if comparison.verdict == "bundled" and not everything:
            continue
        line = f"{answer.name:38s} {answer.type:36s} {answer.md5sum[:8]:8s}"
        out.line("{line}  {what} {of}", line=line, what=say(_WORDS[comparison.verdict]), of=comparison.source)
        if (answer.type, answer.md5sum) in shown and answer.md5sum:
            continue
        shown.add((answer.type, answer.md5sum))
        for line in (*comparison.differences, *([comparison.note] if comparison.note else [])):
            out.line("   ", line)
    counts = Counter(_WORDS[comparison.verdict] for comparison in comparisons).items()
    out.line("{found}", found=[say("{count} {verdict}", count=n, verdict=say(text)) for text, n in counts])


def _keep(
    comparisons: list[Comparison], folder: Path, uri: str, out: Output, skipped: list[str], *, dry: bool
) -> list[Path]:
    """Write new definitions; names that are invalid as files go to `skipped`."""
    from rosproto.transport import parse_uri
    from woosh_pure.firmware.learn import make_sets, why_not_kept, write_set

    new = []
    for comparison in comparisons:
        name, library = comparison.answer.type, comparison.library
        if comparison.verdict == "new" and library is not None:
            why = why_not_kept(name, library)
            if why:
                out.line("not kept: {why}", why=why)
                skipped.append(name)
            else:
                new.append((name, library))
    sets = make_sets(new)
    if not sets:
        out.line("nothing new to keep")
    if dry:
        for learned in sets:
            out.line("would keep {types} below {folder}", types=list(learned.types), folder=folder)
        return []
    written = [write_set(learned, folder, parse_uri(uri)[0]) for learned in sets]
    for path, learned in zip(written, sets, strict=True):
        out.line("kept {types} in {path}", types=list(learned.types), path=path)
    return written


def _document(comparison: Comparison) -> dict[str, object]:
    answer = comparison.answer
    return {
        "kind": answer.kind,
        "name": answer.name,
        "type": answer.type,
        "md5sum": answer.md5sum,
        "peer": answer.peer,
        "verdict": comparison.verdict,
        "source": comparison.source,
        "note": comparison.note,
        "differences": list(comparison.differences),
    }
