"""map_server's files: a small YAML beside an image (wiki.ros.org/map_server, map_saver.cpp,
image_loader.cpp).

Images are PGM or PPM (plain or raw) or PNG. The three modes are read as map_server's image_loader does.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rosproto.numeric import decode_png, is_png
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["load_map", "save_map"]

_MODES = ("trinary", "scale", "raw")
_CHANNELS = {b"P2": 1, b"P5": 1, b"P3": 3, b"P6": 3}
_PLAIN = (b"P2", b"P3")


def load_map(yaml_path: Path, limit_cells: int) -> GridMap:
    """See `GridMap.load`."""
    fields = _parse_yaml(yaml_path)
    pixels = _read_image(yaml_path.parent / fields["image"], limit_cells)
    x, y, yaw = _origin(fields["origin"], yaml_path)
    cells = _cells_of(
        pixels,
        mode=_mode(fields, yaml_path),
        negate=_truth(fields.get("negate", "0"), yaml_path),
        occupied=_number(fields, "occupied_thresh", 0.65, yaml_path),
        free=_number(fields, "free_thresh", 0.196, yaml_path),
    )
    try:
        return GridMap(cells, _number(fields, "resolution", 0.0, yaml_path), Pose2D(x, y, yaw))
    except ValueError as error:
        raise ValueError(f"{yaml_path}: {error}") from error


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


# -- YAML ----------------------------------------------------------------------------------------------------


def _parse_yaml(path: Path) -> dict[str, str]:
    """The keys of the file as text.

    Only what such files are made of, without a YAML library: "key: value", comments, quotes, and lists in one
    line, over several lines, or as items with dashes.
    """
    fields: dict[str, str] = {}
    key = ""
    for line in path.read_text(encoding="utf-8-sig").splitlines():
        text = _without_comment(line)
        bare = text.strip()
        if not bare or bare in ("---", "..."):
            continue
        open_list = key and fields[key].startswith("[") and not fields[key].endswith("]")
        if open_list:
            fields[key] += bare
        elif bare.startswith("- ") and key:
            fields[key] = ", ".join(part for part in (fields[key], bare[2:].strip()) if part)
        else:
            name, colon, value = text.partition(":")
            if not colon:
                raise ValueError(f"{path}: {bare!r} is no line of a map file; expected key: value")
            key = _unquoted(name)
            fields[key] = _unquoted(value)
    missing = {"image", "resolution", "origin"} - fields.keys()
    if missing:
        raise ValueError(
            f"{path}: no {', '.join(sorted(missing))}; expected map_server's keys image, resolution, origin"
        )
    return fields


def _without_comment(line: str) -> str:
    """A "#" begins a comment at the start or after a blank, outside of quotes."""
    quote = ""
    for at, character in enumerate(line):
        if quote:
            quote = "" if character == quote else quote
        elif character in "\"'":
            quote = character
        elif character == "#" and (at == 0 or line[at - 1].isspace()):
            return line[:at]
    return line


def _unquoted(text: str) -> str:
    text = text.strip()
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] and text[0] in "\"'" else text


def _number(fields: dict[str, str], key: str, default: float, path: Path) -> float:
    text = fields.get(key)
    if text is None:
        return default
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{path}: {key} {text!r} is not a number")
    return value


def _truth(text: str, path: Path) -> bool:
    if text.lower() in ("0", "false", "no", "off"):
        return False
    if text.lower() in ("1", "true", "yes", "on"):
        return True
    raise ValueError(f"{path}: negate {text!r} is neither 0 nor 1")


def _mode(fields: dict[str, str], path: Path) -> str:
    mode = fields.get("mode", "trinary").lower()
    if mode not in _MODES:
        raise ValueError(f"{path}: mode {mode!r} is not known; expected {', '.join(_MODES)}")
    return mode


def _origin(text: str, path: Path) -> tuple[float, float, float]:
    try:
        x, y, yaw = (float(part) for part in text.strip("[] ").split(","))
    except ValueError:
        raise ValueError(
            f"{path}: origin {text!r} is not a list of three numbers [x, y, yaw] (m, m, rad)"
        ) from None
    return x, y, yaw


# -- images --------------------------------------------------------------------------------------------------


def _read_image(path: Path, limit_cells: int) -> NDArray[np.uint8]:
    """(height, width, channels) uint8."""
    data = path.read_bytes()
    try:
        return decode_png(data, limit_cells) if is_png(data) else _decode_pnm(data, limit_cells)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _decode_pnm(data: bytes, limit_cells: int) -> NDArray[np.uint8]:
    kind, (width, height, most), start = _pnm_head(data)
    if not (width > 0 and height > 0 and width * height <= limit_cells and 0 < most < 65536):
        raise ValueError(f"{width} x {height} cells of {most} greys; expected at most {limit_cells} cells")
    count = width * height * _CHANNELS[kind]
    if kind in _PLAIN:
        values = _plain_values(data[start:], count)
    else:
        raw = np.dtype(np.uint8 if most < 256 else ">u2")
        values = np.frombuffer(data[start : start + count * raw.itemsize], raw, -1).astype(np.int64)
    if values.size != count:
        raise ValueError(f"{values.size} values, but {width} x {height} are announced; the file is cut short")
    if values.size and not 0 <= int(values.min()) <= int(values.max()) <= most:
        raise ValueError(f"a value is larger than the announced {most}")
    return (values * 255 // most).astype(np.uint8).reshape(height, width, _CHANNELS[kind])


def _plain_values(data: bytes, count: int) -> NDArray[np.int64]:
    lines = (line.partition(b"#")[0] for line in data.splitlines())
    words = b" ".join(lines).split()[:count]
    try:
        return np.array([int(word) for word in words], dtype=np.int64)
    except (ValueError, OverflowError):
        raise ValueError("a value of the plain image is no number") from None


def _pnm_head(data: bytes) -> tuple[bytes, tuple[int, int, int], int]:
    tokens: list[bytes] = []
    at = 0
    while len(tokens) < 4 and at < min(len(data), 65536):
        if data[at : at + 1].isspace():
            at += 1
        elif data[at : at + 1] == b"#":
            at = data.find(b"\n", at) + 1 or len(data)
        else:
            end = at
            while end < len(data) and not data[end : end + 1].isspace() and data[end : end + 1] != b"#":
                end += 1
            tokens.append(data[at:end])
            at = end
    good = (
        len(tokens) == 4 and tokens[0] in _CHANNELS and all(t.isdigit() and len(t) < 10 for t in tokens[1:])
    )
    if not good:
        raise ValueError("neither PGM, PPM (P2, P5, P3, P6 with width, height, greys) nor PNG; convert it")
    return tokens[0], (int(tokens[1]), int(tokens[2]), int(tokens[3])), at + 1


# -- cells ---------------------------------------------------------------------------------------------------


def _cells_of(
    pixels: NDArray[np.uint8], *, mode: str, negate: bool, occupied: float, free: float
) -> NDArray[np.int8]:
    has_alpha = pixels.shape[2] in (2, 4)
    # image_loader.cpp: in trinary mode the alpha counts as one more colour, in the others it does not.
    colours = pixels if mode == "trinary" or not has_alpha else pixels[:, :, :-1]
    grey = colours.sum(axis=2, dtype=np.int64) // colours.shape[2]
    if negate:
        grey = 255 - grey
    if mode == "raw":
        return np.ascontiguousarray(grey.astype(np.uint8).view(np.int8)[::-1])
    share = (255 - grey) / 255.0
    cells = np.full(grey.shape, -1, np.int8)
    if mode == "scale":
        between = 99.0 * (share - free) / max(occupied - free, 1e-9)
        seen = pixels[:, :, -1] > 0 if has_alpha else np.ones(grey.shape, bool)
        cells[seen] = np.clip(between, 0.0, 99.0).astype(np.int8)[seen]
    cells[share < free] = 0
    cells[share > occupied] = 100
    return np.ascontiguousarray(cells[::-1])
