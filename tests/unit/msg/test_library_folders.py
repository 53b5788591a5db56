"""Where libraries look for definitions: folders, packages, workspaces and zip files in ROS layout."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from rosproto.errors import DefinitionError
from rosproto.msg import DefinitionLibrary, bundled
from tests.support.msg_package import package

ROOT = Path(__file__).resolve().parents[3]


class TestFolders:
    """Search paths in ROS layout."""

    def test_a_folder_of_packages_a_package_and_a_workspace(self, tmp_path: Path) -> None:
        ws = tmp_path / "ws"
        package(ws / "src" / "stack" / "a_msgs", msg_Foo="int8 a", srv_Ask="---\n", action_Do="---\n---\n")
        package(ws / "src" / "b_msgs", msg_Bar="a_msgs/Foo foo")
        package(ws / "src" / ".hidden" / "c_msgs", msg_Bar="int8 a")
        package(ws / "src" / "ignored" / "d_msgs", msg_Bar="int8 a")
        (ws / "src" / "ignored" / "CATKIN_IGNORE").touch()
        for path in (ws, ws / "src"):
            found = DefinitionLibrary([path])
            assert found.packages() == ["a_msgs", "b_msgs"]
            assert found.dependencies("b_msgs/Bar") == ["a_msgs/Foo"]
            assert found.services("a_msgs") == ["a_msgs/Ask"]
            assert found.actions("a_msgs") == ["a_msgs/Do"]
        assert DefinitionLibrary([ws / "src" / "b_msgs"]).packages() == ["b_msgs"]

    def test_package_xml_knows_the_name_better_than_the_folder(self, tmp_path: Path) -> None:
        folder = package(tmp_path / "checkout-2", msg_Foo="int8 a")
        (folder / "package.xml").write_text("<package>\n <name> my_msgs </name></package>")
        assert DefinitionLibrary([folder]).packages() == ["my_msgs"]

    def test_the_first_path_wins(self, tmp_path: Path) -> None:
        one = package(tmp_path / "1" / "m", msg_Foo="int8 one")
        two = package(tmp_path / "2" / "m", msg_Foo="int8 two", msg_Bar="Foo foo")
        found = DefinitionLibrary([one, two])
        assert found.message("m/Foo").fields[0].name == "one"
        assert found.messages("m") == ["m/Bar", "m/Foo"]

    def test_paths_of_a_fork_come_before_the_base(self, tmp_path: Path) -> None:
        package(tmp_path / "std_msgs", msg_Bool="int8 mine")
        fork = bundled().fork([tmp_path])
        assert fork.message("std_msgs/Bool").fields[0].name == "mine"
        assert fork.message("std_msgs/Int8").fields[0].name == "data"

    def test_an_error_in_a_file_names_it(self, tmp_path: Path) -> None:
        folder = package(tmp_path / "m", msg_Foo="int8 a\nint8\n")
        with pytest.raises(DefinitionError) as caught:
            DefinitionLibrary([folder]).md5sum("m/Foo")
        assert caught.value.file == os.path.join(str(folder), "msg", "Foo.msg")
        assert caught.value.line == 2

    def test_files_with_other_names_are_no_definitions(self, tmp_path: Path) -> None:
        folder = package(tmp_path / "m", msg_Foo="int8 a")
        (folder / "msg" / "not-a-name.msg").write_text("int8 a")
        (folder / "msg" / "README.md").write_text("words")
        assert DefinitionLibrary([folder]).messages("m") == ["m/Foo"]

    def test_a_path_without_definitions_is_an_error(self, tmp_path: Path) -> None:
        for path in (tmp_path, tmp_path / "nowhere"):
            with pytest.raises(DefinitionError, match="expected"):
                DefinitionLibrary([path])

    def test_old_line_ends_and_odd_bytes_are_read(self, tmp_path: Path) -> None:
        folder = package(tmp_path / "m", msg_Foo="")
        (folder / "msg" / "Foo.msg").write_bytes(b"int8 a # \xff\r\nint8 b\rint8 c\n")
        spec = DefinitionLibrary([folder]).message("m/Foo")
        assert [f.name for f in spec.fields] == ["a", "b", "c"]
        assert "\udcff" in spec.text


def test_definitions_are_read_from_a_zip(tmp_path: Path) -> None:
    """A zip on sys.path, as zipapp makes it: nothing relies on files."""
    archive = tmp_path / "app.zip"
    with zipfile.ZipFile(archive, "w") as file:
        for pattern in (
            "rosproto/errors.py",
            "rosproto/files.py",
            "rosproto/names.py",
            "rosproto/sentence.py",
            "rosproto/text.py",
            "rosproto/msg/*.py",
            "msgdefs/**/*",
        ):
            for path in sorted(ROOT.glob(pattern)):
                if path.is_file() and path.suffix != ".pyi" and "__pycache__" not in path.parts:
                    file.write(path, path.relative_to(ROOT))
        file.writestr("rosproto/__init__.py", "")
    program = (
        "import rosproto.msg as m; lib = m.bundled(); assert '.zip' in m.__file__, m.__file__;"
        "assert lib.md5sum('nav_msgs/Odometry') == 'cd5e73d190d741a2f92e81eda573aca7';"
        "assert 'woosh_msgs' in lib.packages();"
        "assert 'std_msgs/Bool' in lib.messages('std_msgs');"
        "assert len(lib.revisions('woosh_msgs/Battery')) == 1; print('read')"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-c", f"import sys; sys.path.insert(0, {str(archive)!r}); {program}"],
        capture_output=True, text=True, timeout=60, cwd=tmp_path,
    )  # fmt: skip
    assert done.stdout.strip() == "read", done.stderr


def test_where_a_package_is_read_from(tmp_path: Path) -> None:
    """Its folder, of several the one that is asked first; a fork has what its base has."""
    first = package(tmp_path / "one" / "my_msgs", msg_Foo="int8 a")
    second = package(tmp_path / "two" / "my_msgs", msg_Foo="int8 b", msg_Bar="int8 c")
    library = DefinitionLibrary([first, second])
    assert library.folder("my_msgs") == str(first)
    assert library.folder("other_msgs") is None
    assert library.fork().folder("my_msgs") == str(first)
    assert library.fork([second]).folder("my_msgs") == str(second)
    added = DefinitionLibrary()
    added.add(library.message("my_msgs/Foo"))
    assert added.folder("my_msgs") is None
    assert Path(bundled().folder("std_msgs") or "").name == "std_msgs"
    first.rename(tmp_path / "away")  # as in a zip: nothing is in the file system
    assert library.folder("my_msgs") == str(second)
