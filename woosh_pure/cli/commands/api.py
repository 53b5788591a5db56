"""`woosh api`: any question to the Robot API, as JSON."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from contextlib import closing

from rosproto.cli import json_text, positive
from rosproto.errors import CodecError
from rosproto.sentence import say
from woosh_pure.cli.connection import chosen, names, robot_api_of
from woosh_pure.cli.output import Output
from woosh_pure.connection.arguments import master_uri_of
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.api import request_named, robot_api_at


def add_api(parser: ArgumentParser) -> None:
    parser.add_argument("type", nargs="?", metavar="TYPE", help="such as Battery; without it: list all")
    parser.add_argument("body", nargs="?", default="{}", metavar="JSON", help="fields of the request ({})")
    parser.add_argument(
        "--timeout", type=positive, default=30.0, metavar="S", help="seconds for the answer (30)"
    )


def run_api(args: Namespace, out: Output) -> None:
    if args.type is None:
        reads = [name for name, request in wire.requests().items() if request.kind == "read"]
        out.answer(reads, reads)
        return
    name = request_named(args.type)
    try:
        body = json.loads(args.body)
    except ValueError as error:
        raise ValueError(say("{text!r} is not JSON: {error}", text=args.body, error=error)) from error
    if args.sim:
        raise ValueError(
            "--sim has no Robot API; start `woosh sim --robot-api` and give --api-address 127.0.0.1:5480"
        )
    with closing(robot_api_at(robot_api_of(args), master_uri_of(chosen(args)[0]), names(args))) as api:
        try:
            with out.working(say("asking {name}", name=name)):
                found = api.request(name, body, timeout=args.timeout)
        except CodecError as error:
            raise ValueError(str(error)) from error
    answer = wire.dump(wire.requests()[name].answer, found)
    out.answer(answer, json_text(answer, indent=2))
