"""Definitions by name, looked up on first use in added definitions, files and other libraries."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from functools import cache

from rosproto.errors import DefinitionError
from rosproto.msg.definition_files import DefinitionSource, bundled_source, folder_source
from rosproto.msg.full_text import join_full_text
from rosproto.msg.package_revisions import Revision, Row, read_table, revision_source
from rosproto.msg.parser import (
    ACTION_SUFFIXES,
    is_legal_type_name,
    parse_action,
    parse_message,
    parse_service,
)
from rosproto.msg.spec import ActionSpec, MessageSpec, ServiceSpec, md5_text, md5sum_of_texts
from rosproto.text import near_names

Spec = MessageSpec | ServiceSpec | ActionSpec


class DefinitionLibrary:
    """Definitions, found by "package/Type"; "Header" is std_msgs/Header.

    Added definitions come first, then the folders in order, then the base. Nested types are resolved in the
    queried library: a fork that redefines std_msgs/Header has other md5sums for all types that use it.

    Reading is thread-safe. Call `add` before sharing the library.

    Args:
        paths: Folders: a package, a folder of packages, or a workspace with packages below.
        base: Library to search next; none by default. Programs usually use `bundled().fork(paths)`.

    Raises:
        DefinitionError: A path is not a folder or holds no definition.
    """

    def __init__(
        self, paths: Iterable[str | os.PathLike[str]] = (), *, base: DefinitionLibrary | None = None
    ) -> None:
        self._sources: list[DefinitionSource] = [folder_source(path) for path in paths]
        self._base = base
        self._frozen = False
        self._added: dict[tuple[str, str], Spec] = {}
        self._parsed: dict[tuple[str, str], Spec] = {}
        self._found: dict[tuple[str, str], Spec | None] = {}
        self._sums: dict[tuple[str, str], str] = {}
        self._revisions: dict[tuple[str, str], list[Revision]] = {}
        self._tables_read: dict[str, list[tuple[Row, DefinitionLibrary]]] = {}

    # One definition

    def message(self, name: str) -> MessageSpec:
        """A message: a .msg file, one of an action's seven, or a service's Request or Response.

        Raises:
            DefinitionError: None has this name (near matches are listed), or its text is wrong.
        """
        name = "std_msgs/Header" if name == "Header" else name
        found = self._look_up("msg", name)
        if found is None:
            raise self._missing("message", name)
        assert isinstance(found, MessageSpec)
        return found

    def service(self, name: str) -> ServiceSpec:
        """A service. Raises DefinitionError as `message` does."""
        found = self._look_up("srv", name)
        if found is None:
            raise self._missing("service", name)
        assert isinstance(found, ServiceSpec)
        return found

    def action(self, name: str) -> ActionSpec:
        """An action, by "package/MoveBase" or, as in actionlib, "package/MoveBaseAction".

        Raises:
            DefinitionError: None has this name (near matches are listed), or its text is wrong.
        """
        found = self._look_up("action", name)
        if found is None and name.endswith("Action"):
            found = self._look_up("action", name.removesuffix("Action"))
        if found is None:
            raise self._missing("action", name)
        assert isinstance(found, ActionSpec)
        return found

    def md5sum(self, name: str, *, kind: str | None = None) -> str:
        """The md5sum that peers compare.

        Args:
            name: A message (an action's included) or a service.
            kind: "msg" or "srv", for a name that is both; the message by default.

        Raises:
            DefinitionError: The type or one it uses is missing, or a type contains itself.
        """
        name = "std_msgs/Header" if name == "Header" else name
        kind = kind or self._kind(name)
        return self._message_sum(name, ()) if kind == "msg" else self._service_sum(name)

    def dependencies(self, name: str, *, kind: str | None = None) -> list[str]:
        """Names of all types that a message or service uses, each once, in the order of the full text."""
        seen: dict[str, None] = {}
        for spec in self._specs(name, kind):
            self._visit(spec, seen, (spec.name,))
        return list(seen)

    def full_text(self, name: str, *, kind: str | None = None) -> str:
        """The text with those of all types it uses, as genpy's `_full_text`."""
        kind = kind or self._kind(name)
        text = self.message(name).text if kind == "msg" else self.service(name).text
        return join_full_text(
            text, [(used, self.message(used).text) for used in self.dependencies(name, kind=kind)]
        )

    def revisions(self, name: str, *, kind: str | None = None) -> list[Revision]:
        """Other known definitions of a type, one per md5sum, without this library's own.

        Revisions of nested types count: woosh_msgs/Information has those of woosh_msgs/Parameter, and an
        action's messages have those of its goal.
        """
        name = "std_msgs/Header" if name == "Header" else name
        kind = kind or self._kind(name)
        known = self._revisions.get((kind, name))
        if known is None:
            known = self._revisions[kind, name] = self._collect_revisions(name, kind)
        return list(known)

    def package_revisions(self, package: str) -> dict[str, DefinitionLibrary]:
        """Libraries as of each revision of a package, by label, in the order of its table."""
        found = {row.label: library for row, library in self._tables(package)}
        return {**(self._base.package_revisions(package) if self._base is not None else {}), **found}

    def field_aliases(self, name: str) -> list[tuple[str, str]]:
        """Pairs of names of the same field: the vendor's page spells some differently."""
        package, _, base = name.partition("/")
        found = [
            pair
            for source in self._sources
            for folder in source.folders.get(package, ())
            for pair in folder.field_aliases(base)
        ]
        return found + (self._base.field_aliases(name) if self._base is not None else [])

    # Contents

    def packages(self) -> list[str]:
        """Names of all packages, sorted."""
        found = {name.partition("/")[0] for _, name in self._added}
        for source in self._sources:
            found.update(source.folders)
        return sorted(found.union(self._base.packages() if self._base else ()))

    def folder(self, package: str) -> str | None:
        """The first folder with definitions of a package; None if there is none."""
        for source in self._sources:
            for folder in source.folders.get(package, ()):
                if folder.path is not None:
                    return folder.path
        return None if self._base is None else self._base.folder(package)

    def messages(self, package: str) -> list[str]:
        """Full names of a package's messages, including those of its actions, sorted."""
        derived = {name + suffix for name in self.actions(package) for suffix in ACTION_SUFFIXES}
        return sorted(derived.union(self._names("msg", package)))

    def services(self, package: str) -> list[str]:
        """Full names of a package's services, sorted."""
        return sorted(self._names("srv", package))

    def actions(self, package: str) -> list[str]:
        """Full names of a package's actions, sorted."""
        return sorted(self._names("action", package))

    # Making libraries

    def add(self, spec: Spec) -> None:
        """Add a definition, which takes precedence over others of that name.

        Raises:
            DefinitionError: This library is shared (`bundled()`): add to a `fork()` of it.
        """
        if self._frozen:
            raise DefinitionError(f"{spec.name}: the bundled definitions are shared; add to bundled().fork()")
        if isinstance(spec, ActionSpec):
            self._added["action", spec.name] = spec
        elif isinstance(spec, ServiceSpec):
            self._added["srv", spec.name] = spec
        else:
            self._added["msg", spec.name] = spec
        for cached in (self._found, self._sums, self._revisions, self._tables_read):
            cached.clear()

    def fork(self, paths: Iterable[str | os.PathLike[str]] = ()) -> DefinitionLibrary:
        """A library based on this one; `paths` and definitions added to it take precedence."""
        return DefinitionLibrary(paths, base=self)

    # Internals

    def _look_up(self, kind: str, name: str) -> Spec | None:
        key = (kind, name)
        try:
            return self._found[key]
        except KeyError:
            pass
        spec: Spec | None = None
        if is_legal_type_name(name):
            spec = self._own(kind, name)
            if spec is None and self._base is not None:
                spec = self._base._look_up(kind, name)
        # Names may come from peers: missing ones are not cached, which bounds the memory.
        if spec is not None:
            self._found[key] = spec
        return spec

    def _own(self, kind: str, name: str) -> Spec | None:
        known = self._added.get((kind, name)) or self._parsed.get((kind, name))
        if known is not None:
            return known
        package, _, base = name.partition("/")
        for source in self._sources:
            found = source.read(package, kind, base)
            if found is not None:
                spec = self._parsed[kind, name] = _parse(kind, found[0], name, found[1])
                return spec
        return self._derived(name) if kind == "msg" else None

    def _derived(self, name: str) -> MessageSpec | None:
        """A message of an action or a service."""
        for suffix in ACTION_SUFFIXES:
            if name.endswith(suffix) and not name.endswith("/" + suffix):
                action = self._own("action", name.removesuffix(suffix))
                if isinstance(action, ActionSpec):
                    return action.messages[name]
        for suffix in ("Request", "Response"):
            if name.endswith(suffix) and not name.endswith("/" + suffix):
                service = self._own("srv", name.removesuffix(suffix))
                if isinstance(service, ServiceSpec):
                    return service.request if suffix == "Request" else service.response
        return None

    def _kind(self, name: str) -> str:
        name = "std_msgs/Header" if name == "Header" else name
        if self._look_up("msg", name) is not None:
            return "msg"
        if self._look_up("srv", name) is not None:
            return "srv"
        raise self._missing("message or service", name)

    def _specs(self, name: str, kind: str | None) -> tuple[MessageSpec, ...]:
        if (kind or self._kind(name)) == "msg":
            return (self.message(name),)
        service = self.service(name)
        return (service.request, service.response)

    def _message_sum(self, name: str, trail: tuple[str, ...]) -> str:
        known = self._sums.get(("msg", name))
        if known is None:
            known = self._sums["msg", name] = md5sum_of_texts(self._text_to_hash(self.message(name), trail))
        return known

    def _service_sum(self, name: str) -> str:
        known = self._sums.get(("srv", name))
        if known is None:
            spec = self.service(name)
            known = md5sum_of_texts(
                self._text_to_hash(spec.request, ()), self._text_to_hash(spec.response, ())
            )
            self._sums["srv", name] = known
        return known

    def _text_to_hash(self, spec: MessageSpec, trail: tuple[str, ...]) -> str:
        trail = (*trail, spec.name)

        def sum_of(used: str) -> str:
            self._check_use(spec, used, trail)
            return self._message_sum(used, trail)

        return md5_text(spec, sum_of)

    def _check_use(self, spec: MessageSpec, used: str, trail: tuple[str, ...]) -> None:
        if used in trail:
            loop = " -> ".join([*trail[trail.index(used) :], used])
            raise DefinitionError(f"{used} contains itself: {loop}; no value of it could ever end")
        if self._look_up("msg", used) is None:
            field = next(field.name for field in spec.fields if field.type.base == used)
            raise self._missing("message", used, f"{spec.name}.{field}: ")

    def _visit(self, spec: MessageSpec, seen: dict[str, None], trail: tuple[str, ...]) -> None:
        for field in spec.fields:
            used = field.type.base
            if field.type.is_builtin:
                continue
            self._check_use(spec, used, trail)
            # The types that a seen type uses follow it directly, as in genmsg.
            if used not in seen:
                seen[used] = None
                self._visit(self.message(used), seen, (*trail, used))

    def _names(self, kind: str, package: str) -> Iterator[str]:
        prefix = package + "/"
        for added_kind, name in self._added:
            if added_kind == kind and name.startswith(prefix):
                yield name
        for source in self._sources:
            yield from (prefix + base for base in source.names(package, kind))
        if self._base is not None:
            yield from self._base._names(kind, package)

    def _missing(self, what: str, name: str, prefix: str = "") -> DefinitionError:
        package, _, base = name[:300].partition("/")
        packages = self.packages()
        known = [*self.messages(package), *self.services(package)] if package in packages else []
        # Bounded: a library from the network may hold many long names, which are slow to compare.
        names = [other.partition("/")[2] for other in known[:500]] if len(base) <= 64 else []
        near = near_names(base, names)
        if near:
            hint = "did you mean " + ", ".join(f"{package}/{other}" for other in near) + "?"
        elif known:
            hint = f"the package is known, with {len(known)} other types"
        elif package in packages:
            hint = "the package is known, but empty"
        else:
            hint = "the package is not known" + "".join(
                f"; did you mean {other}?" for other in near_names(package, packages)[:1]
            )
        looked = ", ".join(self._places()) or "nothing: the library is empty"
        return DefinitionError(f"{prefix}no {what} {name[:300]!r}: {hint} (looked in {looked})")

    def _places(self) -> Iterator[str]:
        if self._added:
            yield f"{len(self._added)} added definitions"
        for source in self._sources:
            yield source.where
        if self._base is not None:
            yield from self._base._places()

    def _collect_revisions(self, name: str, kind: str) -> list[Revision]:
        own = self.md5sum(name, kind=kind)
        found: dict[str, Revision] = {}
        for label, library, note in self._revision_libraries(name, kind):
            try:
                md5sum = library.md5sum(name, kind=kind)
            except DefinitionError:
                continue  # the type is newer than that revision
            if md5sum != own:
                found.setdefault(md5sum, Revision(name, label, md5sum, library, note))
        if self._base is not None:
            for revision in self._base.revisions(name, kind=kind) if self._base.has(kind, name) else ():
                if revision.md5sum != own:
                    found.setdefault(revision.md5sum, revision)
        return list(found.values())

    def has(self, kind: str, name: str) -> bool:
        """Whether there is a definition of that kind: "msg", "srv" or "action"."""
        return self._look_up(kind, name) is not None

    def defines(self, kind: str, name: str) -> bool:
        """Like `has`, without the base."""
        return is_legal_type_name(name) and self._own(kind, name) is not None

    def _revision_libraries(self, name: str, kind: str) -> Iterator[tuple[str, DefinitionLibrary, str]]:
        used = {name, *self.dependencies(name, kind=kind)}
        for package in sorted({other.partition("/")[0] for other in used}):
            for row, library in self._tables(package):
                yield row.label, library, row.note_for(package, used)

    def _tables(self, package: str) -> list[tuple[Row, DefinitionLibrary]]:
        """Rows of a package's revision tables with their libraries, cached so that types share classes."""
        known = self._tables_read.get(package)
        if known is None:
            known = []
            for source in self._sources:
                for folder in source.folders.get(package, ()):
                    libraries: dict[str, DefinitionLibrary] = {"": self}
                    for row in read_table(folder):
                        library = DefinitionLibrary(base=libraries[row.after])
                        library._sources = [revision_source(folder, package, row.label)]
                        libraries[row.label] = library
                        known.append((row, library))
            known = self._tables_read.setdefault(package, known)
        return known


def _parse(kind: str, text: str, name: str, file: str) -> Spec:
    if kind == "msg":
        return parse_message(text, name, file=file)
    return parse_service(text, name, file=file) if kind == "srv" else parse_action(text, name, file=file)


@cache
def bundled() -> DefinitionLibrary:
    """The definitions in this package: common ROS ones and the chassis's.

    The process shares one library: add definitions to a `fork()`.
    """
    library = DefinitionLibrary()
    library._sources = [bundled_source()]
    library._frozen = True
    return library
