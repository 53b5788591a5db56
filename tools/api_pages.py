"""A hook of MkDocs: the API reference as one page for each class, and one for the functions of each module.

The pages under docs/api list modules and classes with `::: name`. Written out on one page they would be
hundreds of kilobytes; here each name gets a page of its own, and the listing becomes links with the first
line of the docstring.
"""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

DIRECTIVE = re.compile(r"^::: (\S+)$", re.MULTILINE)


@dataclass(frozen=True)
class Entry:
    """One generated page."""

    uri: str  # "api/woosh_pure/Chassis.md"
    title: str
    summary: str  # first line of the docstring
    body: str


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Put the pages below their listing page in the menu."""
    config.nav = _with_entries(config.nav, Path(config.docs_dir))
    return config


def _with_entries(item: Any, docs: Path) -> Any:
    if isinstance(item, list):
        return [_with_entries(part, docs) for part in item]
    if isinstance(item, dict):
        return {title: _with_entries(part, docs) for title, part in item.items()}
    if isinstance(item, str) and item.startswith("api/"):
        title = re.sub(r"^# (API: )?", "", (docs / item).read_text("utf-8").partition("\n")[0])
        return {title: [item, *({entry.title: entry.uri} for entry in entries(docs, item))]}
    return item


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages."""
    docs = Path(config.docs_dir)
    for page in sorted(docs.glob("api/*.md")):
        for entry in entries(docs, f"api/{page.name}"):
            files.append(File.generated(config, entry.uri, content=f"# {entry.title}\n\n{entry.body}\n"))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Replace the directives of a listing page by links."""
    uri = page.file.src_uri
    if not re.fullmatch(r"api/\w+\.md", uri):
        return markdown
    found = entries(Path(config.docs_dir), uri)
    rows = "\n".join(f"- [{e.title}]({e.uri.removeprefix('api/')}): {e.summary}" for e in found)
    return f"{DIRECTIVE.sub('', markdown).strip()}\n\n{rows}\n"


def entries(docs: Path, uri: str) -> list[Entry]:
    """The pages of one listing page, in its order.

    Raises:
        ImportError, AttributeError: A directive names nothing that exists.
    """
    folder = uri.removesuffix(".md")
    found: dict[str, Entry] = {}
    for name in DIRECTIVE.findall((docs / uri).read_text("utf-8")):
        for entry in _of_directive(name, folder):
            if entry.uri in found:  # two packages have a class of that name
                package = name.partition(".")[0]
                uri_of_package = entry.uri.replace(f"{folder}/", f"{folder}/{package}-")
                entry = replace(entry, uri=uri_of_package, title=f"{entry.title} ({package})")
            found[entry.uri] = entry
    return list(found.values())


def _of_directive(name: str, folder: str) -> Iterator[Entry]:
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError:
        home, _, short = name.rpartition(".")
        yield _class_page(getattr(importlib.import_module(home), short), name, folder)
        return
    classes = {n: c for n, c in _own(module) if inspect.isclass(c)}
    for short, found in classes.items():
        yield _class_page(found, f"{name}.{short}", folder)
    others = [n for n, found in _own(module) if not inspect.isclass(found)]
    if others:
        short = name.rpartition(".")[2]
        members = "".join(f"\n        - {n}" for n in others)
        body = (
            f"::: {name}\n    options:\n      show_root_heading: false\n      show_root_toc_entry: false\n"
            f"      members:{members}"
        )
        # Not `graph.md` beside `Graph.md`: they would be one file on Windows and macOS.
        yield Entry(f"{folder}/functions-of-{short}.md", f"Functions of {short}", _summary(module), body)


def _class_page(found: Any, name: str, folder: str) -> Entry:
    short = name.rpartition(".")[2]
    return Entry(f"{folder}/{short}.md", short, _summary(found), f"`{name}`\n\n::: {name}")


def _own(module: ModuleType) -> Iterator[tuple[str, Any]]:
    """Public classes and functions that this module defines, in its order."""
    for name, found in vars(module).items():
        public = not name.startswith("_") and getattr(found, "__module__", None) == module.__name__
        if public and (inspect.isclass(found) or inspect.isfunction(found)):
            yield name, found


def _summary(found: Any) -> str:
    return (inspect.getdoc(found) or "").partition("\n\n")[0].replace("\n", " ")
