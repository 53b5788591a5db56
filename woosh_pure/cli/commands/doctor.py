"""`woosh doctor`: checks the connection and the chassis."""

from __future__ import annotations

import json
import platform
import socket
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
from contextlib import ExitStack
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

import rosproto
from rosproto.errors import RosError
from rosproto.sentence import say
from rosproto.version import __version__
from woosh_pure.cli.arguments import seconds
from woosh_pure.cli.connection import chosen, names, simulated
from woosh_pure.cli.output import Output

if TYPE_CHECKING:
    from woosh_pure.doctor.checks import Finding

HELP = "say in plain words why it does not work; moves nothing"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "--listen", type=seconds, default=3.0, metavar="S", help="seconds to listen (default 3)"
    )
    parser.add_argument(
        "--report",
        type=Path,
        metavar="FILE",
        help="write it to a file, too, with versions and the graph, without addresses, hosts and folders",
    )


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    from woosh_pure.connection.arguments import master_uri_of
    from woosh_pure.doctor.checks import Level
    from woosh_pure.doctor.examination import examine

    if args.report is not None and args.report.exists():
        raise ValueError(say("{path} exists already: give another name", path=args.report))
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
        if args.report is not None:
            _write_report(args.report, master_uri_of(address), names(args), findings)
    bad = sum(f.level is Level.PROBLEM for f in findings)
    if bad:
        out.line(say("{count} problem", count=bad) if bad == 1 else say("{count} problems", count=bad))
    else:
        out.line("no problem was found")
    if args.report is not None:
        out.line(say("the report is in {path}: look through it before you send it", path=args.report))
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


def _write_report(path: Path, uri: str, resolve: Mapping[str, str], findings: list[Finding]) -> None:
    """Write the JSON report of `woosh_pure.doctor.report`."""
    from rosproto.transport import HostNames
    from woosh_pure.doctor.report import Redaction, report

    state, types = None, {}
    try:
        with rosproto.MasterClient(uri, "/woosh_doctor", timeout=3.0, hosts=HostNames(resolve)) as client:
            state, types = client.get_system_state(), client.get_topic_types()
    except RosError:
        pass  # the findings have the reason
    system = {
        "woosh-pure": __version__,
        "python": sys.version,
        "system": platform.platform(),
        "numpy": metadata.version("numpy"),
        "lz4": metadata.version("lz4"),
    }
    redact = Redaction([socket.gethostname(), *resolve], str(Path.home()))
    document = report(findings, state, types, system, redact)
    path.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", "utf-8")
