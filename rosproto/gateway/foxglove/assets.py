"""`Assets`: serves files of packages to viewers that draw a robot: `package://NAME/meshes/base.stl`.

Only files in the given folders, of types that describe a robot, and never through a symbolic link out of the
package.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import unquote

from rosproto.gateway.chunks import ChunkedMessage, framed
from rosproto.gateway.foxglove.messages import FetchAsset, asset_failure, asset_head

SCHEME = "package://"
KINDS = frozenset(
    ".stl .dae .obj .mtl .gltf .glb .bin .ply .urdf .xacro .sdf"
    " .png .jpg .jpeg .tif .tiff .webp .bmp .tga".split()
)
MAX_ASSET_BYTES = 32 << 20


class AssetAnswer:
    """A file for a viewer, read when the viewer is ready for it; a `DeferredPayload`."""

    quick = False

    def __init__(self, assets: Assets, asked: FetchAsset) -> None:
        self._assets = assets
        self._asked = asked

    def payloads(self) -> tuple[bytes | ChunkedMessage, ...]:
        try:
            data = self._assets.fetch(self._asked.uri)
        except (OSError, ValueError) as problem:
            return (asset_failure(self._asked.request, str(problem)),)
        return (framed(asset_head(self._asked.request), data),)


class Assets:
    """Folders with packages, as in ROS_PACKAGE_PATH: a package is a subfolder with its name.

    Args:
        folders: Searched in this order; a folder may itself be a package.
    """

    def __init__(self, folders: Iterable[str | os.PathLike[str]] = ()) -> None:
        self.folders = tuple(Path(folder) for folder in folders)

    def __bool__(self) -> bool:
        return bool(self.folders)

    def fetch(self, uri: str) -> bytes:
        """Return the contents of a file.

        Raises:
            ValueError: The address is malformed, or the file has another type or is too large.
            FileNotFoundError: None of the folders has it.
        """
        if not uri.startswith(SCHEME) or len(uri) > 1024:
            raise ValueError(f"{uri[:100]!r} is not an address of a package's file: package://NAME/PATH")
        package, _, inside = unquote(uri[len(SCHEME) :]).partition("/")
        parts = inside.split("/")
        if not package or package.startswith(".") or "" in parts or any(p in (".", "..") for p in parts):
            raise ValueError(f"{uri[:100]!r} does not name a file of a package")
        if any(sign in package + inside for sign in "\\:\0"):
            raise ValueError(f"{uri[:100]!r} contains characters that are not allowed in a file of a package")
        if Path(inside).suffix.lower() not in KINDS:
            raise ValueError(f"{uri[:100]!r}: only meshes, textures and robot descriptions are served")
        for folder in self.folders:
            root = folder if folder.name == package else folder / package
            found = self._read(root, parts, uri)
            if found is not None:
                return found
        raise FileNotFoundError(f"{uri[:100]!r}: no such file in the folders of --assets")

    def _read(self, root: Path, parts: list[str], uri: str) -> bytes | None:
        try:
            real, home = root.joinpath(*parts).resolve(strict=True), root.resolve(strict=True)
            if not real.is_relative_to(home) or not real.is_file():
                return None
            with real.open("rb") as file:
                data = file.read(MAX_ASSET_BYTES + 1)
        except OSError:
            return None
        if len(data) > MAX_ASSET_BYTES:
            raise ValueError(f"{uri[:100]!r} is larger than {MAX_ASSET_BYTES} bytes")
        return data
