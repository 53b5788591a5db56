"""`woosh connect HOST`: save the default chassis."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.sentence import both, say, sentence_of
from woosh_pure.cli import config
from woosh_pure.cli.output import Output

HELP = "remember a chassis, so that the other commands need no address"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("address", nargs="?", metavar="HOST", help="host or master URI, e.g. 169.254.128.2")
    parser.add_argument("--show", action="store_true", help="show what is remembered")
    parser.add_argument("--forget", action="store_true", help="forget it")
    parser.add_argument("--unchecked", action="store_true", help="do not try to reach it first")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    address = args.address or args.master or args.chassis
    if sum((bool(address), args.show, args.forget)) != 1:
        raise ValueError("give the address of a chassis, or --show, or --forget")
    if args.sim:
        raise ValueError("--sim needs no connecting: use it with any other command")
    if args.forget:
        return _forget(out)
    return _show(out) if args.show else _save(address, args, out)


def _save(address: str, args: Namespace, out: Output) -> int:
    from woosh_pure.connection.arguments import master_uri_of

    uri = master_uri_of(address)
    if not args.unchecked:
        _require_master(uri, args, out)
    path = config.save(config.Profile(address, args.host))
    out.line(say("{uri} is now the default chassis (in {path})", uri=uri, path=path))
    out.result({"chassis": address, "master_uri": uri, "host": args.host, "file": str(path)})
    return 0


def _require_master(uri: str, args: Namespace, out: Output) -> None:
    from rosproto import MasterClient
    from rosproto.transport import HostNames
    from woosh_pure.cli.connection import names

    try:
        hosts = HostNames(names(args))
        with (
            out.working(say("looking for {uri}", uri=uri)),
            MasterClient(uri, "/woosh_connect", timeout=5.0, hosts=hosts) as master,
        ):
            master.get_pid()
    except (ConnectionLost, RosTimeout) as error:
        not_saved = say("nothing was saved: try `woosh doctor`, or add --unchecked")
        why = both(error.why, not_saved) if error.why else ""
        raise ConnectionLost(both(sentence_of(error), not_saved), peer=error.peer, why=why) from error


def _show(out: Output) -> int:
    profile = config.load()
    if profile is None:
        out.line("no chassis is remembered; `woosh connect HOST` does it")
    else:
        shown = "{chassis}, our address {host} (in {path})" if profile.host else "{chassis} (in {path})"
        out.line(say(shown, chassis=profile.chassis, host=profile.host, path=config.profile_file()))
    out.result(
        {
            "chassis": profile.chassis if profile else None,
            "host": profile.host if profile else None,
            "file": str(config.profile_file()),
        }
    )
    return 0 if profile else 1


def _forget(out: Output) -> int:
    known = config.forget()
    out.line("forgotten" if known else "no chassis was remembered")
    out.result({"forgotten": known})
    return 0
