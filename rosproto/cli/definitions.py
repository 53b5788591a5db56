"""`rosproto msg|srv|action`: show, list, md5, package, packages; output as of rosmsg and rossrv."""

from __future__ import annotations

import argparse
from functools import partial
from typing import TYPE_CHECKING

from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import unknown
from rosproto.cli.graph_options import Verb, add_verbs, library_for
from rosproto.cli.options import add_allow_damaged, add_json
from rosproto.cli.parser import near

if TYPE_CHECKING:
    from rosproto.msg import DefinitionLibrary


def _add_arguments(kind: str, parser: argparse.ArgumentParser) -> None:
    table: dict[str, Verb] = {
        "show": (_show_arguments, _show, "print a definition with the types it uses unfolded"),
        "info": (_show_arguments, _show, "the same as show"),
        "list": (_common, _list, "list every type there is"),
        "md5": (_type_arguments, _md5, "print the md5sum that peers compare"),
        "package": (_package_arguments, _package, "list the types of a package"),
        "packages": (_packages_arguments, _packages, "list the packages that have types of this kind"),
    }
    if kind == "action":
        del table["md5"]
    add_verbs(parser, table, graph=False)
    parser.set_defaults(kind=kind)


add_arguments_msg = partial(_add_arguments, "msg")
add_arguments_srv = partial(_add_arguments, "srv")
add_arguments_action = partial(_add_arguments, "action")


def _common(parser: argparse.ArgumentParser) -> None:
    add_json(parser)
    parser.add_argument(
        "--msg-path", action="append", default=[], metavar="FOLDER", help="a folder with packages of your own"
    )


def _type_arguments(parser: argparse.ArgumentParser) -> None:
    _common(parser)
    parser.add_argument("type", nargs="+", help="package/Type, or Type alone to look in every package")


def _show_arguments(parser: argparse.ArgumentParser) -> None:
    _type_arguments(parser)
    parser.add_argument("-r", "--raw", action="store_true", help="the text as it was written, with comments")
    parser.add_argument("-b", "--bag", metavar="FILE", help="the definition that a bag holds (messages only)")
    add_allow_damaged(parser)


def _package_arguments(parser: argparse.ArgumentParser) -> None:
    _packages_arguments(parser)
    parser.add_argument("package")


def _packages_arguments(parser: argparse.ArgumentParser) -> None:
    _common(parser)
    parser.add_argument("-s", "--single-line", action="store_true", help="all on a single line")


def _library(arguments: argparse.Namespace) -> DefinitionLibrary:
    from rosproto.msg import bundled
    from rosproto.msg.user_folder import environment_paths

    folders = [*arguments.msg_path, *environment_paths()]
    return bundled().fork(folders) if folders else bundled()


def _library_of(arguments: argparse.Namespace, name: str) -> DefinitionLibrary:
    """Return the library that `topic pub` and `service call` use for this type."""
    from rosproto.msg import bundled

    return library_for(arguments, name, arguments.kind) or bundled()


def _names(library: DefinitionLibrary, kind: str, package: str) -> list[str]:
    listing = {"msg": library.messages, "srv": library.services, "action": library.actions}[kind]
    return sorted(name if "/" in name else f"{package}/{name}" for name in listing(package))


def _all(library: DefinitionLibrary, kind: str) -> list[str]:
    return [name for package in sorted(library.packages()) for name in _names(library, kind, package)]


def _asked(library: DefinitionLibrary, arguments: argparse.Namespace) -> list[tuple[str, bool]]:
    """Return (full name, whether the package was searched for) pairs."""
    found: list[tuple[str, bool]] = []
    for name in (name.removesuffix(f".{arguments.kind}") for name in arguments.type):
        if "/" in name:
            found.append((name, False))
            continue
        matches = [full for full in _all(library, arguments.kind) if full.partition("/")[2] == name]
        if not matches:
            known = {full.partition("/")[2] for full in _all(library, arguments.kind)}
            raise unknown(f"no {arguments.kind} is called", name, known, f"{arguments.kind} list")
        found += [(full, True) for full in matches]
    return found


def _joined(arguments: argparse.Namespace) -> str:
    return " " if arguments.single_line else "\n"


def _in_bag(arguments: argparse.Namespace) -> DefinitionLibrary:
    """Return the requested definitions from a bag."""
    from rosproto.cli.bag_files import opened
    from rosproto.msg import DefinitionLibrary, library_from_full_text

    if arguments.kind != "msg":
        raise ValueError("--bag: bags hold messages only, no services and actions")
    with opened(arguments.bag, arguments) as bag:
        texts = {c.type: c.definition for t in bag.topics.values() for c in t.connections}
    found = DefinitionLibrary()
    for name in arguments.type:
        if name not in texts:
            raise CommandError(
                f"{arguments.bag} has no {name}{near(name, texts)}; "
                f"it has: {', '.join(sorted(texts)) or 'none'}"
            )
        found = library_from_full_text(name, texts[name], base=found)
    return found


def _show(arguments: argparse.Namespace) -> None:
    given = _in_bag(arguments) if arguments.bag else None
    text_of = _raw if arguments.raw else _unfolded
    shown = []
    for name, looked_for in _asked(given or _library(arguments), arguments):
        text = text_of(given or _library_of(arguments, name), arguments.kind, name)
        shown.append({"type": name, "definition": text})
        if not arguments.json:
            print((f"[{name}]:\n" if looked_for else "") + text + "\n")
    arguments.out.record(shown)


def _raw(library: DefinitionLibrary, kind: str, name: str) -> str:
    if kind == "msg":
        return library.message(name).text.rstrip("\n")
    return (library.service(name) if kind == "srv" else library.action(name)).text.rstrip("\n")


def _unfolded(library: DefinitionLibrary, kind: str, name: str) -> str:
    from rosproto.msg.spec import unfolded

    if kind == "msg":
        parts = [library.message(name)]
    elif kind == "srv":
        service = library.service(name)
        parts = [service.request, service.response]
    else:
        action = library.action(name)
        parts = [action.goal, action.result, action.feedback]
    return "\n---\n".join("\n".join(unfolded(part, library.message)) for part in parts)


def _list(arguments: argparse.Namespace) -> None:
    names = _all(_library(arguments), arguments.kind)
    arguments.out.answer(names, names)


def _md5(arguments: argparse.Namespace) -> None:
    library = _library(arguments)
    asked = [name for name, _ in _asked(library, arguments)]
    sums = {name: _library_of(arguments, name).md5sum(name, kind=arguments.kind) for name in asked}
    alone = "/" in arguments.type[0] and len(sums) == 1
    lines = [md5sum if alone else f"[{name}]: {md5sum}" for name, md5sum in sums.items()]
    arguments.out.answer(sums, lines)


def _package(arguments: argparse.Namespace) -> None:
    library = _library(arguments)
    if arguments.package not in library.packages():
        names = library.packages()
        raise unknown("no package is called", arguments.package, names, f"{arguments.kind} packages")
    names = _names(library, arguments.kind, arguments.package)
    arguments.out.answer(names, _joined(arguments).join(names))


def _packages(arguments: argparse.Namespace) -> None:
    library = _library(arguments)
    packages = [p for p in sorted(library.packages()) if _names(library, arguments.kind, p)]
    arguments.out.answer(packages, _joined(arguments).join(packages))
