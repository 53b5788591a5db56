"""Where the user's revisions are, on each system."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.msg import bundled
from rosproto.msg.user_folder import learned_paths, library_of, own_and_learned, revisions_folder


@pytest.mark.parametrize(
    ("platform", "environment", "place"),
    [
        ("linux", {"HOME": "/home/a"}, "/home/a/.local/share/rosproto/revisions"),
        ("linux", {"HOME": "/home/a", "XDG_DATA_HOME": "/data"}, "/data/rosproto/revisions"),
        ("linux", {"HOME": "/home/a", "XDG_DATA_HOME": "data"}, "/home/a/.local/share/rosproto/revisions"),
        ("darwin", {"HOME": "/Users/a"}, "/Users/a/Library/Application Support/rosproto/revisions"),
        ("win32", {"LOCALAPPDATA": "/c/a/Local", "USERPROFILE": "/c/a"}, "/c/a/Local/rosproto/revisions"),
        ("win32", {"USERPROFILE": "/c/a"}, "/c/a/AppData/Local/rosproto/revisions"),
    ],
)
def test_each_system_has_its_place(platform: str, environment: dict[str, str], place: str) -> None:
    """Data of an application, not its configuration or cache."""
    assert revisions_folder(environment, platform) == Path(place)


def test_sets_are_folders_with_definitions(tmp_path: Path) -> None:
    """What is being written, empty or a file is not a set; a folder that is not there has none."""
    assert learned_paths(tmp_path / "nowhere") == []
    for name in ("b", "a", ".new-c"):
        (tmp_path / name / "my_msgs" / "msg").mkdir(parents=True)
        (tmp_path / name / "my_msgs" / "msg" / "Note.msg").write_text("string text\n")
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("")
    assert learned_paths(tmp_path) == [tmp_path / "a", tmp_path / "b"]


@pytest.mark.parametrize("platform", ["linux", "darwin", "win32"])
def test_a_user_without_a_home_has_learned_nothing(platform: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A container with an arbitrary user id and no HOME: the library works, and learning says what to set."""

    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", no_home)
    for name in ("HOME", "USERPROFILE", "LOCALAPPDATA", "XDG_DATA_HOME"):
        monkeypatch.delenv(name, raising=False)
    assert learned_paths() == []
    with pytest.raises(FileNotFoundError, match="USERPROFILE" if platform == "win32" else "HOME"):
        revisions_folder({}, platform)
    if platform != "darwin":  # where the folder is named, no home is needed
        named = {"LOCALAPPDATA": "/data", "XDG_DATA_HOME": "/data"}
        assert revisions_folder(named, platform) == Path("/data/rosproto/revisions")


def a_set(folder: Path, package: str, **messages: str) -> Path:
    """A folder of definitions, as `msg_path=` takes it."""
    (folder / package / "msg").mkdir(parents=True)
    for name, text in messages.items():
        (folder / package / "msg" / f"{name}.msg").write_text(text)
    return folder


def test_the_users_own_definitions_come_before_learned_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Given by hand, then $ROSPROTO_MSG_PATH, then the bundled ones; learned ones only for what nobody has."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "data"))
    monkeypatch.setenv("HOME", str(tmp_path / "data"))
    learned = a_set(revisions_folder() / "robot", "my_msgs", Note="int8 learned\n", Rest="int8 rest\n")
    a_set(learned, "std_msgs", Bool="int8 learned\n")
    exported = a_set(tmp_path / "exported", "my_msgs", Note="int8 exported\n")
    a_set(exported, "std_msgs", Bool="int8 exported\n")
    given = a_set(tmp_path / "given", "my_msgs", Note="int8 given\n")

    monkeypatch.delenv("ROSPROTO_MSG_PATH", raising=False)
    assert own_and_learned([given]) == [given, learned]
    assert own_and_learned([given], learned=False) == [given]
    assert library_of("std_msgs/Bool") is None
    assert library_of("my_msgs/Nothing") is None
    assert library_of("my_msgs/Note", learned=False) is None
    found = library_of("my_msgs/Note")
    assert found is not None
    assert found.message("my_msgs/Note").fields[0].name == "learned"
    assert found.message("std_msgs/Int8") == bundled().message("std_msgs/Int8")

    monkeypatch.setenv("ROSPROTO_MSG_PATH", str(exported))
    assert own_and_learned([given]) == [given, str(exported), learned]
    for name, paths, field in [
        ("my_msgs/Note", [given], "given"),
        ("my_msgs/Note", [], "exported"),
        ("std_msgs/Bool", [given], "exported"),
        ("my_msgs/Rest", [given], "rest"),
    ]:
        found = library_of(name, given=paths)
        assert found is not None
        assert found.message(name).fields[0].name == field
