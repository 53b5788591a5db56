"""`woosh doctor`: why it does not work."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from contextlib import ExitStack

from rosproto.sentence import say
from woosh_pure.cli.arguments import seconds
from woosh_pure.cli.connection import chosen, names, simulated
from woosh_pure.cli.output import Output

HELP = "say in plain words why it does not work; moves nothing"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "--listen", type=seconds, default=3.0, metavar="S", help="seconds to listen (default 3)"
    )


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    from woosh_pure.connection.arguments import master_uri_of
    from woosh_pure.doctor.checks import Level
    from woosh_pure.doctor.examination import examine

    with ExitStack() as stack:
        address: str | None
        address, host = (simulated(args, out, stack), args.host) if args.sim else chosen(args)
        findings = []
        found = examine(master_uri_of(address), host=host, listen=args.listen, resolve=names(args))
        for finding in found:
            findings.append(finding)
            out.line(out.cell(finding.level.value, 8), finding.text)
            if finding.advice:
                out.line(out.cell("", 8), "->", finding.advice)
    bad = sum(f.level is Level.PROBLEM for f in findings)
    if bad:
        out.line(say("{count} problem", count=bad) if bad == 1 else say("{count} problems", count=bad))
    else:
        out.line("no problem was found")
    out.result(
        {
            "ok": bad == 0,
            "findings": [
                {"check": f.check, "level": f.level.value.lower(), "text": f.text, "advice": f.advice}
                for f in findings
            ],
        }
    )
    return 1 if bad else 0
