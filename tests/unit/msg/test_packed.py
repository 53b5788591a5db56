"""All definitions in one file, as a wheel has them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rosproto.msg import DefinitionLibrary, bundled
from rosproto.msg import sources as sources_module
from rosproto.msg.packed import PACK, PackedTree, make_pack
from rosproto.msg.sources import FileTree, bundled_source

ROOT = Path(__file__).resolve().parents[3]


def packed_library(text: str) -> DefinitionLibrary:
    """A library of nothing but this pack."""
    library = DefinitionLibrary()
    tree = PackedTree("msgdefs", text)
    names = [name for name in tree.names() if sources_module.is_legal_base(name)]
    library._sources = [
        sources_module.Source("msgdefs", {name: [sources_module.Folder(tree, name)] for name in names})
    ]
    return library


@pytest.fixture(scope="module")
def text() -> str:
    return make_pack(ROOT / "msgdefs")


def paths(tree: FileTree | PackedTree, *parts: str) -> Iterator[tuple[str, ...]]:
    """Paths of all definition files and tables of a tree."""
    for name in sorted(tree.names(*parts)):
        if name.endswith((".msg", ".srv", ".action", ".txt")):
            yield (*parts, name)
        elif "." not in name or parts[-1:] == ("revisions",):
            yield from paths(tree, *parts, name)


def test_every_file_is_in_it_word_for_word(text: str) -> None:
    """Names, folders and texts are those of the files."""
    files, pack = FileTree(str(ROOT / "msgdefs")), PackedTree("msgdefs", text)
    found = list(paths(files))
    assert len(found) > 250
    assert found == list(paths(pack))
    for parts in found:
        assert pack.read(*parts) == files.read(*parts)
    assert pack.describe(*found[0]) == "msgdefs/" + "/".join(found[0])
    assert pack.names("no", "such", "folder") == frozenset()


def test_the_library_is_the_same(text: str) -> None:
    """Packages, md5sums, revisions and their notes."""
    ours, theirs = packed_library(text), bundled()
    assert ours.packages() == theirs.packages()
    for package in theirs.packages():
        assert ours.messages(package) == theirs.messages(package)
        assert ours.actions(package) == theirs.actions(package)
        assert ours.services(package) == theirs.services(package)
        for name in [*theirs.messages(package), *theirs.services(package)]:
            assert ours.md5sum(name) == theirs.md5sum(name)
            assert labels(ours, name) == labels(theirs, name)
    assert labels(theirs, "woosh_msgs/Battery")


def labels(library: DefinitionLibrary, name: str) -> list[tuple[str, str, str]]:
    """What is known of the revisions of a type."""
    return [(revision.label, revision.md5sum, revision.note) for revision in library.revisions(name)]


def test_an_installed_package_reads_the_pack(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`bundled_source` takes the one file where it is, and the files where it is not."""
    package = tmp_path / "packed_definitions"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / PACK).write_text(text, "utf-8", newline="\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    tree = sources_module.ResourceTree
    monkeypatch.setattr(sources_module, "ResourceTree", lambda name: tree("packed_definitions"))
    found = bundled_source().read("std_msgs", "msg", "Header")
    assert found is not None
    assert found[0] == (ROOT / "msgdefs/std_msgs/msg/Header.msg").read_text("utf-8")


def test_a_form_feed_is_refused(tmp_path: Path) -> None:
    """It would begin another file."""
    (tmp_path / "A.msg").write_text("int8 a\f")
    with pytest.raises(ValueError, match=r"A\.msg: has a form feed"):
        make_pack(tmp_path)


def test_texts_may_be_changed_on_the_way_into_the_pack(tmp_path: Path) -> None:
    (tmp_path / "A.msg").write_text("int8 a\n")
    assert make_pack(tmp_path, change=str.upper) == "\fA.msg\nINT8 A\n"
