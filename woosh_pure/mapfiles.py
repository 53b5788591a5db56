"""map_server's files: a small YAML beside a PGM image (wiki.ros.org/map_server, map_saver.cpp,
image_loader.cpp)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .geometry import Pose2D
from .gridmap import GridMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["load_map", "save_map"]


def load_map(yaml_path: Path, limit_cells: int) -> GridMap:
    """See `GridMap.load`."""
    fields = _parse_yaml(yaml_path)
    image = yaml_path.parent / fields["image"].strip("\"'")
    grey = _read_pgm(image, limit_cells)
    x, y, yaw = _numbers(fields["origin"], yaml_path)
    cells = _cells_of(
        grey,
        negate=fields.get("negate", "0").strip() in ("1", "true", "True"),
        occupied=float(fields.get("occupied_thresh", "0.65")),
        free=float(fields.get("free_thresh", "0.196")),
    )
    return GridMap(cells, float(fields["resolution"]), Pose2D(x, y, yaw))


def save_map(grid: GridMap, yaml_path: Path) -> tuple[Path, Path]:
    """See `GridMap.save`."""
    yaml_path = yaml_path.with_suffix(".yaml")
    image = yaml_path.with_suffix(".pgm")
    head = f"P5\n# {grid.resolution:.3f} m/pix\n{grid.width} {grid.height}\n255\n"
    image.write_bytes(head.encode("ascii") + grid.to_grey().tobytes())
    o = grid.origin
    lines = (
        f"image: {image.name}",
        f"resolution: {grid.resolution:.6f}",
        f"origin: [{o.x:.6f}, {o.y:.6f}, {o.yaw:.6f}]",
        "negate: 0",
        "occupied_thresh: 0.65",
        "free_thresh: 0.196",
        "",
    )
    yaml_path.write_text("\n".join(lines), encoding="utf-8", newline="\n")
    return yaml_path, image


def _parse_yaml(path: Path) -> dict[str, str]:
    # Only the flat "key: value" form that map_saver writes: no YAML library is needed for it.
    fields: dict[str, str] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        key, colon, value = line.split("#")[0].partition(":")
        if colon:
            fields[key.strip()] = value.strip()
    missing = {"image", "resolution", "origin"} - fields.keys()
    if missing:
        raise ValueError(
            f"{path}: no {', '.join(sorted(missing))}; expected map_server's keys image, resolution, origin"
        )
    if fields.get("mode", "trinary") != "trinary":
        raise ValueError(f"{path}: mode {fields['mode']} is not supported; save the map in mode trinary")
    return fields


def _numbers(text: str, path: Path) -> tuple[float, float, float]:
    try:
        x, y, yaw = (float(part) for part in text.strip("[] ").split(","))
    except ValueError:
        raise ValueError(
            f"{path}: origin {text!r} is not a list of three numbers [x, y, yaw] (m, m, rad)"
        ) from None
    return x, y, yaw


def _read_pgm(path: Path, limit_cells: int) -> NDArray[np.uint8]:
    data = path.read_bytes()
    kind, values, start = _pgm_head(data, path)
    width, height, most = values
    if not (width > 0 and height > 0 and width * height <= limit_cells and 0 < most < 256):
        raise ValueError(
            f"{path}: {width} x {height} cells of {most} greys; expected at most {limit_cells} cells, 8 bit"
        )
    if kind == b"P2":
        grey = np.array(data[start:].split()[: width * height], dtype=np.uint8)
    else:
        grey = np.frombuffer(data, np.uint8, offset=start)[: width * height]
    if grey.size != width * height:
        raise ValueError(
            f"{path}: {grey.size} pixels, but {width} x {height} are announced; the file is cut short"
        )
    return (grey.astype(np.float64) * (255.0 / most)).astype(np.uint8).reshape(height, width)


def _pgm_head(data: bytes, path: Path) -> tuple[bytes, tuple[int, int, int], int]:
    tokens: list[bytes] = []
    at = 0
    while len(tokens) < 4 and at < min(len(data), 4096):
        if data[at : at + 1].isspace():
            at += 1
        elif data[at : at + 1] == b"#":
            at = data.find(b"\n", at) + 1 or len(data)
        else:
            end = at
            while end < len(data) and not data[end : end + 1].isspace():
                end += 1
            tokens.append(data[at:end])
            at = end
    if len(tokens) < 4 or tokens[0] not in (b"P2", b"P5") or not all(t.isdigit() for t in tokens[1:]):
        raise ValueError(f"{path}: not a PGM image (P5 or P2 with width, height, greys)")
    return tokens[0], (int(tokens[1]), int(tokens[2]), int(tokens[3])), at + 1


def _cells_of(grey: NDArray[np.uint8], *, negate: bool, occupied: float, free: float) -> NDArray[np.int8]:
    value = grey.astype(np.float64) / 255.0
    probability = value if negate else 1.0 - value
    cells = np.full(grey.shape, -1, np.int8)
    cells[probability < free] = 0
    cells[probability > occupied] = 100
    return np.ascontiguousarray(cells[::-1])
