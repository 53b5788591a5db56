"""Definitions of the user's own, and learned ones, in the commands."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto import Master, Node
from rosproto.cli import main
from rosproto.codec import service_class
from rosproto.msg import bundled


def package(folder: Path, service: str) -> Path:
    """A folder with my_msgs/Ask."""
    place = folder / "my_msgs" / "srv"
    place.mkdir(parents=True)
    (place / "Ask.srv").write_text(service)
    return folder


@pytest.mark.parametrize("how", ["given", "learned", "left out"])
def test_a_service_of_another_revision_is_called(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """--msg-path, and what was learned, give the definition; --no-learned does without."""
    home = {"given": "elsewhere", "learned": "home", "left out": "home"}[how]
    for variable in ("XDG_DATA_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.setenv(variable, str(tmp_path / home))
    from rosproto.msg.user_folder import revisions_folder

    mine = package(tmp_path / "mine", "int32 a\n---\nint32 b\n")
    kept = revisions_folder() / "robot-1" if how != "given" else tmp_path / "robots"
    theirs = service_class("my_msgs/Ask", bundled().fork([package(kept, "int64 a\n---\nint64 b\n")]))
    options = {"given": ["--msg-path", str(kept)], "learned": [], "left out": ["--no-learned"]}[how]
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False) as robot,
        robot.service_server("/ask", theirs, lambda request: {"b": request.a + 1}),
    ):
        words = [
            "service",
            "call",
            "/ask",
            "{a: 1}",
            "--master",
            master.uri,
            "--msg-path",
            str(mine),
            *options,
        ]
        code = main(words)
    said = capsys.readouterr()
    if how == "left out":
        assert code != 0
        assert "woosh learn" in said.err
    else:
        assert (code, said.out.strip()) == (0, "b: 2")
