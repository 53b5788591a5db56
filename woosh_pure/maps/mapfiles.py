"""Read and write map_server's files: a YAML and its image (wiki.ros.org/map_server, map_saver.cpp,
image_loader.cpp).

Images are PGM or PPM (plain or raw) or PNG. The three modes are read as by map_server's image_loader.
"""

from __future__ import annotations

import json
import math
import re
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rosproto.files import read_text, write_file
from rosproto.logs import get_logger
from rosproto.numeric import decode_png, is_png
from rosproto.sentence import say
from rosproto.typed_values import parse_value
from woosh_pure.geometry import Pose2D

if TYPE_CHECKING:
    from numpy.typing import NDArray

_log = get_logger("woosh_pure.maps")
_MODES = ("trinary", "scale", "raw")
_ENDINGS = (".yaml", ".yml", ".pgm", ".png")
_PLAIN_NAME = re.compile(r"\w[\w .-]*")  # without YAML's syntax
_UNKNOWN_GREY = 205  # of map_saver, also of nav2's in mode trinary
_CHANNELS = {b"P2": 1, b"P5": 1, b"P3": 3, b"P6": 3}
_PLAIN = (b"P2", b"P3")
MAX_PICTURE_CELLS, MAX_PICTURE_ROWS = 1 << 26, 1 << 15
_HEAD_BYTES = 1 << 16
_SPARE_BYTES = 16 << 20  # for comments, colour profiles and the like
_PNG_SIZE = struct.Struct(">II")
_COMMENT = re.compile(r"""(?<![^\s\[,:])("(?:\\.|[^"\\])*(?:"|$)|'[^']*(?:'|$))|(?<!\S)#.*""")
"""A text in quotes, which is kept, or a comment: "#" at the start or after a blank."""
_SPACE = rb"(?:\s|#[^\n]*\n)"
_PNM_HEAD = re.compile(_SPACE + rb"*(P[2356])" + (_SPACE + rb"+([0-9]{1,9})") * 3 + rb"(?=[\s#]|\Z)")


def read_map(
    yaml_path: Path, limit_cells: int, *, beside: bool = False
) -> tuple[NDArray[np.int8], float, Pose2D]:
    """Read cells, resolution and origin; see `GridMap.load`."""
    fields = _read_yaml(yaml_path)
    image = fields["image"]
    if beside:
        image = image.replace("\\", "/").rpartition("/")[2]
    mode, negate = _mode(fields, yaml_path), _truth(fields.get("negate", 0), yaml_path)
    free, occupied = _thresholds(fields, mode, yaml_path)
    resolution, origin = _number(fields, "resolution", 0.0, yaml_path), _origin(fields["origin"], yaml_path)
    pixels = _read_image(yaml_path.parent / image, limit_cells)
    grey = _grey_of(pixels, mode=mode, negate=negate)
    cells = _cells_of(pixels, grey, mode=mode, occupied=occupied, free=free)
    if mode == "trinary" and (unknown := int((cells[::-1][grey == _UNKNOWN_GREY] == 0).sum())):
        _log.warning(
            "%s",
            say(
                "{path}: free_thresh {free} makes {unknown} cells free that map_saver wrote as unknown "
                "(grey 205); to keep them unknown, write free_thresh: 0.196",
                path=yaml_path,
                free=free,
                unknown=unknown,
            ),
        )
    return cells, resolution, origin


def cells_of_picture(picture: bytes) -> NDArray[np.int8]:
    """The cells of a PNG whose first row has the largest y: dark is occupied, light free, the rest unknown.

    Raises:
        ValueError: It is not such a picture, or too large.
    """
    pixels = decode_png(picture, MAX_PICTURE_CELLS, MAX_PICTURE_ROWS)
    cells = _cells_of(
        pixels, _grey_of(pixels, mode="scale", negate=False), mode="trinary", occupied=0.65, free=0.196
    )
    if _has_alpha(pixels):
        cells[pixels[::-1, :, -1] == 0] = -1  # transparent
    return cells


def write_map(
    yaml_path: Path, grey: NDArray[np.uint8], resolution: float, origin: Pose2D
) -> tuple[Path, Path]:
    """Write a map; see `GridMap.save`."""
    name = yaml_path.stem if yaml_path.suffix in _ENDINGS else yaml_path.name
    if not (name and name.isprintable()):
        raise ValueError(
            say("{name!r} cannot be the name of a map; give one of printable characters", name=name)
        )
    yaml_path, image = yaml_path.with_name(f"{name}.yaml"), yaml_path.with_name(f"{name}.pgm")
    height, width = grey.shape
    head = f"P5\n# {resolution:.3f} m/pix\n{width} {height}\n255\n"
    write_file(image, head.encode("ascii") + grey.tobytes())
    write_file(yaml_path, yaml_of(image.name, resolution, origin).encode())
    return yaml_path, image


def yaml_of(image: str, resolution: float, origin: Pose2D) -> str:
    """Return the YAML of a map in mode trinary whose image has map_saver's greys."""
    # JSON's texts are YAML.
    name = image if _PLAIN_NAME.fullmatch(image) else json.dumps(image, ensure_ascii=False)
    return (
        f"image: {name}\nresolution: {resolution:.6f}\n"
        f"origin: [{origin.x:.6f}, {origin.y:.6f}, {origin.yaw:.6f}]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )


# -- YAML ----------------------------------------------------------------------------------------------------


def _read_yaml(path: Path) -> dict[str, Any]:
    """Read the YAML; values are parsed as on a command line, "image" stays a text."""
    fields: dict[str, Any] = {}
    for key, text in _entries(path).items():
        try:
            fields[key] = _image_name(text) if key == "image" else parse_value(text)
        except ValueError as error:
            raise ValueError(say("{path}: {key} {error}", path=path, key=key, error=error)) from None
    missing = {"image", "resolution", "origin"} - fields.keys()
    if missing:
        raise ValueError(
            say(
                "{path}: no {names}; expected map_server's keys image, resolution, origin",
                path=path,
                names=", ".join(sorted(missing)),
            )
        )
    return fields


def _image_name(text: str) -> str:
    """A plain or quoted text; backslashes in double quotes that cannot be YAML's escapes are of Windows."""
    if text[:1] not in ("'", '"'):
        return text
    try:
        name = parse_value(text)
    except ValueError:
        if text[0] != '"' or not text.endswith('"'):
            raise
    else:
        if isinstance(name, str) and name.isprintable():
            return name
    return text[1:-1]


def _entries(path: Path) -> dict[str, str]:
    """The "key: value" lines as texts; a list may be on one line, on several lines, or as items with
    dashes."""
    found: dict[str, list[str]] = {}  # the value, then the items with dashes below it
    key = ""
    for line in read_text(path, "utf-8-sig").splitlines():
        text = _COMMENT.sub(r"\1", line).strip()
        if not text or text in ("---", "..."):
            continue
        if key and found[key][0].startswith("[") and not found[key][0].endswith("]"):
            found[key][0] += text
        elif text.startswith("- ") and key:
            found[key].append(text[2:])
        else:
            name, colon, value = text.partition(":")
            if not colon:
                raise ValueError(
                    say(
                        "{path}: {text!r} is not a line of a map file; expected key: value",
                        path=path,
                        text=text,
                    )
                )
            key = name.strip().strip("\"'")
            found[key] = [value.strip()]
    return {key: f"[{', '.join(items)}]" if items else value for key, (value, *items) in found.items()}


def _number(fields: dict[str, Any], key: str, default: float, path: Path) -> float:
    value = fields.get(key, default)
    number = _float(value)
    if not math.isfinite(number):
        raise ValueError(say("{path}: {key} {value!r} is not a number", path=path, key=key, value=value))
    return number


def _thresholds(fields: dict[str, Any], mode: str, path: Path) -> tuple[float, float]:
    """free_thresh and occupied_thresh: shares of black. map_server takes any number."""
    free = _number(fields, "free_thresh", 0.196, path)
    occupied = _number(fields, "occupied_thresh", 0.65, path)
    if mode != "raw" and not 0 <= free <= occupied < 1:
        raise ValueError(
            say(
                "{path}: free_thresh {free} and occupied_thresh {occupied} would lose walls or free space; "
                "expected 0 <= free_thresh <= occupied_thresh < 1 (0 is white, 1 is black), "
                "for example map_saver's 0.196 and 0.65",
                path=path,
                free=free,
                occupied=occupied,
            )
        )
    return free, occupied


def _float(value: object) -> float:
    """A number, also in quotes; NaN if invalid."""
    try:
        return math.nan if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return math.nan


def _truth(value: object, path: Path) -> bool:
    text = str(value).lower()
    if text not in ("0", "false", "no", "off", "1", "true", "yes", "on"):
        raise ValueError(say("{path}: negate {value!r} is neither 0 nor 1", path=path, value=value))
    return text in ("1", "true", "yes", "on")


def _mode(fields: dict[str, Any], path: Path) -> str:
    mode = str(fields.get("mode", "trinary")).lower()
    if mode not in _MODES:
        raise ValueError(
            say(
                "{path}: mode {mode!r} is not known; expected {names}",
                path=path,
                mode=mode,
                names=", ".join(_MODES),
            )
        )
    return mode


def _origin(value: object, path: Path) -> Pose2D:
    parts = parse_value(f"[{value}]") if isinstance(value, str) else value  # brackets are optional
    try:
        x, y, yaw = map(float, parts)  # type: ignore[call-overload]
    except (TypeError, ValueError):
        raise ValueError(
            say(
                "{path}: origin {value!r} is not a list of three numbers [x, y, yaw] (m, m, rad)",
                path=path,
                value=value,
            )
        ) from None
    if math.isfinite(yaw) and abs(yaw) > math.tau:
        raise ValueError(
            say(
                "{path}: the origin's yaw {yaw} is more than one turn; it is in radians: "
                "{yaw} degrees are {radians:.6f}",
                path=path,
                yaw=yaw,
                radians=math.radians(yaw),
            )
        )
    return Pose2D(x, y, yaw)


# -- images --------------------------------------------------------------------------------------------------


def _read_image(path: Path, limit_cells: int) -> NDArray[np.uint8]:
    """Read an image as (height, width, channels) uint8."""
    try:
        with path.open("rb") as file:
            data = file.read(_HEAD_BYTES)
            data += file.read(_most_bytes(data, limit_cells))
        return decode_png(data, limit_cells) if is_png(data) else _decode_pnm(data, limit_cells)
    except ValueError as error:
        raise ValueError(say("{path}: {error}", path=path, error=error)) from error


def _most_bytes(head: bytes, limit_cells: int) -> int:
    """The largest size of the rest of an image; a device or a pipe may never end."""
    if is_png(head):
        cells: int = math.prod(_PNG_SIZE.unpack_from(head, 16)) if len(head) >= 24 else 0
        return _SPARE_BYTES + 9 * min(cells, limit_cells)  # uncompressed, 4 channels of 16 bits
    kind, (width, height, _), _ = _pnm_head(head)
    return _SPARE_BYTES + 6 * _CHANNELS[kind] * min(width * height, limit_cells)  # 5 digits and a blank


def _decode_pnm(data: bytes, limit_cells: int) -> NDArray[np.uint8]:
    kind, (width, height, maximum), start = _pnm_head(data)
    if not (width > 0 and height > 0 and width * height <= limit_cells and 0 < maximum < 65536):
        raise ValueError(
            say(
                "{width} x {height} cells of {maximum} greys; expected at most {limit_cells} cells",
                width=width,
                height=height,
                maximum=maximum,
                limit_cells=limit_cells,
            )
        )
    count = width * height * _CHANNELS[kind]
    if kind in _PLAIN:
        values = _plain_values(data[start:], count)
    else:
        raw = np.dtype(np.uint8 if maximum < 256 else ">u2")
        values = np.frombuffer(data[start : start + count * raw.itemsize], raw, -1).astype(np.int64)
    if values.size != count:
        raise ValueError(
            say(
                "{size} values, but {width} x {height} are announced; the file is cut short",
                size=values.size,
                width=width,
                height=height,
            )
        )
    if values.size and not 0 <= int(values.min()) <= int(values.max()) <= maximum:
        raise ValueError(say("a value is larger than the announced {maximum}", maximum=maximum))
    return (values * 255 // maximum).astype(np.uint8).reshape(height, width, _CHANNELS[kind])


def _plain_values(data: bytes, count: int) -> NDArray[np.int64]:
    lines = (line.partition(b"#")[0] for line in data.splitlines())
    words = b" ".join(lines).split()[:count]
    try:
        return np.array([int(word) for word in words], dtype=np.int64)
    except (ValueError, OverflowError):
        raise ValueError("a value of the plain image is not a number") from None


def _pnm_head(data: bytes) -> tuple[bytes, tuple[int, int, int], int]:
    """The kind, (width, height, greys), and where the pixels begin."""
    found = _PNM_HEAD.match(data[:_HEAD_BYTES])
    if found is None:
        raise ValueError("neither PGM, PPM (P2, P5, P3, P6 with width, height, greys) nor PNG; convert it")
    return found[1], (int(found[2]), int(found[3]), int(found[4])), found.end() + 1


# -- cells ---------------------------------------------------------------------------------------------------


def _has_alpha(pixels: NDArray[np.uint8]) -> bool:
    return pixels.shape[2] in (2, 4)


def _grey_of(pixels: NDArray[np.uint8], *, mode: str, negate: bool) -> NDArray[np.int64]:
    # image_loader.cpp: trinary mode treats alpha as another colour, the other modes do not.
    colours = pixels if mode == "trinary" or not _has_alpha(pixels) else pixels[:, :, :-1]
    grey: NDArray[np.int64] = colours.sum(axis=2, dtype=np.int64) // colours.shape[2]
    return np.subtract(255, grey) if negate else grey


def _cells_of(
    pixels: NDArray[np.uint8], grey: NDArray[np.int64], *, mode: str, occupied: float, free: float
) -> NDArray[np.int8]:
    if mode == "raw":
        return np.ascontiguousarray(grey.astype(np.uint8).view(np.int8)[::-1])
    share = (255 - grey) / 255.0
    cells = np.full(grey.shape, -1, np.int8)
    if mode == "scale":
        between = 99.0 * (share - free) / max(occupied - free, 1e-9)
        seen = pixels[:, :, -1] > 0 if _has_alpha(pixels) else np.ones(grey.shape, bool)
        cells[seen] = np.clip(between, 0.0, 99.0).astype(np.int8)[seen]
    cells[share < free] = 0
    cells[share > occupied] = 100
    return np.ascontiguousarray(cells[::-1])
