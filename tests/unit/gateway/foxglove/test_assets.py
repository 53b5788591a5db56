"""Files of packages for viewers: those of a robot's description, and no other file of this computer."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.gateway.foxglove import assets as assets_module
from rosproto.gateway.foxglove.assets import Assets


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    meshes = tmp_path / "share" / "my_robot" / "meshes"
    meshes.mkdir(parents=True)
    (meshes / "base.stl").write_bytes(b"solid")
    (meshes / "notes.txt").write_text("private")
    (meshes / "large.dae").write_bytes(b"x" * 2000)
    (tmp_path / "secret.stl").write_text("secret")
    return tmp_path / "share"


def test_a_mesh_of_a_package(folder: Path) -> None:
    """Found in a folder of packages, and in a package given itself."""
    assert Assets([folder]).fetch("package://my_robot/meshes/base.stl") == b"solid"
    assert Assets([folder / "my_robot"]).fetch("package://my_robot/meshes/base.stl") == b"solid"
    assert Assets(["/nowhere", folder]).fetch("package://my_robot/meshes/base%2Estl") == b"solid"
    assert not Assets()


@pytest.mark.promise("Files are served from named folders only")
@pytest.mark.parametrize(
    "uri",
    [
        "file:///etc/passwd",
        "package://my_robot",
        "package:///meshes/base.stl",
        "package://my_robot/../../secret.stl",
        "package://my_robot/meshes/%2e%2e/%2e%2e/%2e%2e/secret.stl",
        "package://../secret.stl",
        "package://./secret.stl",
        "package://my_robot/meshes/notes.txt",
        "package://my_robot//etc/base.stl",
        "package://my_robot/meshes\\base.stl",
        "package://my_robot/C:/base.stl",
        "package://my_robot/meshes/base.stl\0",
        "package://my_robot/" + "a" * 2000 + ".stl",
    ],
)
def test_what_is_no_file_of_a_robot(folder: Path, uri: str) -> None:
    """Refused by its name alone."""
    with pytest.raises(ValueError):
        Assets([folder]).fetch(uri)


@pytest.mark.promise("Files are served from named folders only")
def test_what_is_not_there_or_leads_out_or_is_too_large(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A link out of the package is not a file of it."""
    monkeypatch.setattr(assets_module, "MAX_ASSET_BYTES", 1000)
    assets = Assets([folder])
    with pytest.raises(FileNotFoundError):
        assets.fetch("package://my_robot/meshes/other.stl")
    with pytest.raises(ValueError, match="larger than 1000"):
        assets.fetch("package://my_robot/meshes/large.dae")
    try:
        (folder / "my_robot" / "meshes" / "out.stl").symlink_to(folder.parent / "secret.stl")
    except OSError:
        pytest.skip("this user may not make links")
    with pytest.raises(FileNotFoundError):
        assets.fetch("package://my_robot/meshes/out.stl")
