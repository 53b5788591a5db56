"""What seldom happens to definitions: odd installations, unreadable files, types that a revision has not."""

from __future__ import annotations

import os
import sys
import zipfile
from pathlib import Path

import pytest

from rosproto.errors import DefinitionError
from rosproto.files import MAX_FILE_BYTES
from rosproto.msg import DefinitionLibrary, bundled, parse_message
from rosproto.msg.definition_files import FileTree, ResourceTree
from rosproto.msg.spec import unfolded
from rosproto.msg.user_folder import environment_paths


def package(folder: Path, **texts: str) -> Path:
    """A package m with these files: kind_Name="text"."""
    for key, text in texts.items():
        kind, _, name = key.partition("_")
        (folder / "m" / kind).mkdir(parents=True, exist_ok=True)
        (folder / "m" / kind / f"{name}.{kind}").write_text(text)
    return folder / "m"


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    """It was listed, and is gone when it is asked for."""
    with pytest.raises(DefinitionError, match="cannot be read: No such file") as caught:
        FileTree(str(tmp_path)).read("msg", "Gone.msg")
    assert caught.value.file == os.path.join(str(tmp_path), "msg", "Gone.msg")
    assert FileTree(str(tmp_path)).names("none") == frozenset()


def test_a_definition_without_end_is_refused(tmp_path: Path) -> None:
    """Not read until the memory is gone: nobody writes a definition of 64 MiB."""
    (tmp_path / "Endless.msg").touch()
    os.truncate(tmp_path / "Endless.msg", MAX_FILE_BYTES + 1)
    with pytest.raises(DefinitionError, match="more than 67108864 bytes") as caught:
        FileTree(str(tmp_path)).read("Endless.msg")
    assert str(caught.value.file) == str(tmp_path / "Endless.msg")


@pytest.fixture
def zipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """An importable package within a zip."""
    name = "zipped_definitions"
    with zipfile.ZipFile(tmp_path / "app.zip", "w") as file:
        file.writestr(f"{name}/__init__.py", "")
        file.writestr(f"{name}/m/msg/Foo.msg", "int8 x\n")
    monkeypatch.syspath_prepend(str(tmp_path / "app.zip"))
    yield name
    sys.modules.pop(name, None)


def test_definitions_in_a_zip(zipped: str) -> None:
    """The loader reads; importlib.resources lists."""
    tree = ResourceTree(zipped)
    assert tree.names("m", "msg") == {"Foo.msg"}
    assert tree.names("m", "srv") == tree.names("none") == frozenset()
    assert tree.read("m", "msg", "Foo.msg") == "int8 x\n"
    assert tree.describe("m", "msg", "Foo.msg") == f"{zipped}/m/msg/Foo.msg"
    with pytest.raises(DefinitionError, match="cannot be read"):
        tree.read("m", "msg", "Gone.msg")


def test_folders_are_searched_to_a_depth(tmp_path: Path) -> None:
    """A home folder given by mistake does not take minutes; hidden and ignored folders are left out."""
    deep = tmp_path
    for name in "abcdefghij":
        deep = deep / name
    package(deep, msg_Foo="int8 x")
    with pytest.raises(DefinitionError, match="no definitions found up to"):
        DefinitionLibrary([tmp_path])
    package(tmp_path / ".hidden", msg_Foo="int8 x")
    package(tmp_path / "left", msg_Foo="int8 x")
    (tmp_path / "left" / "CATKIN_IGNORE").touch()
    (tmp_path / "empty" / "msg").mkdir(parents=True)
    package(tmp_path / "near", msg_Bar="int8 x")
    assert DefinitionLibrary([tmp_path]).messages("m") == ["m/Bar"]


def test_types_that_are_younger_than_a_revision(tmp_path: Path) -> None:
    """A revision that lacks what a type is made of says nothing about it."""
    folder = package(
        tmp_path, msg_Foo="int8 a\nint8 b", msg_Part="int8 x", msg_Whole="Part p\nYoung y", msg_Young="int8 x"
    )
    (folder / "revisions" / "old" / "msg").mkdir(parents=True)
    (folder / "revisions" / "old" / "msg" / "Whole.msg").write_text("Part p\nGone g\n")
    (folder / "revisions" / "revisions.txt").write_text("old <\n  Whole: with a type that is not there\n")
    library = DefinitionLibrary([folder])
    assert library.revisions("m/Whole") == []
    assert library.revisions("m/Foo") == []


def test_revisions_of_a_base_that_are_now_the_definition() -> None:
    """A library that redefines a type as one of its base's revisions has the others only."""
    (page,) = bundled().revisions("woosh_msgs/Battery")
    library = bundled().fork()
    library.add(page.library.message("woosh_msgs/Battery"))
    assert page.md5sum not in [revision.md5sum for revision in library.revisions("woosh_msgs/Battery")]
    alone = bundled().fork()
    alone.add(parse_message("int8 x", "woosh_msgs/Own"))
    assert alone.revisions("woosh_msgs/Own") == []


def test_a_folder_of_revisions_without_a_table(tmp_path: Path) -> None:
    """It is nobody's revision: nothing says what it is a change of."""
    folder = package(tmp_path, msg_Foo="int8 a")
    (folder / "revisions" / "old" / "msg").mkdir(parents=True)
    assert DefinitionLibrary([folder]).revisions("m/Foo") == []


@pytest.mark.parametrize("suffix", ["Goal", "ActionGoal", "Action", "Result", "Request", "Response"])
def test_names_that_only_look_derived(suffix: str) -> None:
    """A name may end like those of actions and services without there being any."""
    library = bundled().fork()
    assert not library.has("msg", f"std_msgs/Nothing{suffix}")
    assert not library.has("msg", f"std_msgs/{suffix}")
    library.add(parse_message("int8 x", f"std_msgs/Nothing{suffix}"))
    assert library.message(f"std_msgs/Nothing{suffix}").fields[0].name == "x"


def test_a_package_with_nothing_in_it(tmp_path: Path) -> None:
    """The error tells a package that is empty from one that is not known."""
    folder = package(tmp_path, action_Do="int8 x\n---\n---\n")
    with pytest.raises(DefinitionError, match=r"m/Dogoal.* did you mean .*m/DoGoal"):
        DefinitionLibrary([folder]).message("m/Dogoal")
    hollow = tmp_path / "hollow"
    (hollow / "e" / "msg").mkdir(parents=True)
    (hollow / "e" / "msg" / "not a name.msg").write_text("")
    with pytest.raises(DefinitionError, match="the package is known, but empty"):
        DefinitionLibrary([hollow]).message("e/Foo")


def test_folders_in_the_environment() -> None:
    """As in $PATH; nothing given is nothing."""
    assert environment_paths({}) == []
    assert environment_paths({"ROSPROTO_MSG_PATH": os.pathsep.join(["/a", "", "/b"])}) == ["/a", "/b"]
    assert isinstance(environment_paths(), list)


def test_a_message_is_unfolded_with_the_messages_in_it() -> None:
    library = DefinitionLibrary()
    library.add(parse_message("uint8 ONE=1\nuint8 kind\n", "a/Inner"))
    library.add(parse_message("a/Inner[2] pair\nstring name\n", "a/Outer"))
    assert list(unfolded(library.message("a/Outer"), library.message)) == [
        "a/Inner[2] pair", "  uint8 ONE=1", "  uint8 kind", "string name",
    ]  # fmt: skip
