"""Maps of map_server: all forms of YAML and images, and the errors for broken ones."""

from __future__ import annotations

import struct
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest

from rosproto.numeric.pngfile import decode_png
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.mapfiles import cells_of_picture

YAML = "image: m.pgm\nresolution: 0.05\norigin: [-1.5, 2.0, 0.25]\n"
GREYS = bytes([0, 254, 205, 100])
# Top row of the image is the far (north) row of the map.
CELLS = [[-1, -1], [100, 0]]


def load(tmp_path, yaml, image=b"P5\n2 2\n255\n" + GREYS, name="m.pgm"):
    target = tmp_path / name
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(image)
    (tmp_path / "m.yaml").write_bytes(yaml if isinstance(yaml, bytes) else yaml.encode())
    return GridMap.load(tmp_path / "m.yaml")


@pytest.mark.parametrize(
    "yaml",
    [
        YAML,
        YAML.replace("\n", "\r\n"),
        "\ufeff" + YAML,
        "---\n# a map\n"
        + YAML
        + "negate: 0  # not inverted\noccupied_thresh: 0.65\nfree_thresh: 0.196\n...\n",
        "origin: [-1.5,\n  2.0, 0.25]\nresolution:   5e-2\nimage: 'm.pgm'  # the picture\n",
        'image: "m.pgm"\norigin:\n- -1.5\n- 2.0\n- 0.25\nresolution: 0.05\nmode: trinary\n',
        "origin:\n  - -1.5\n  - 2.0\n  - 0.25\nimage: m.pgm\nresolution: 0.05\nnegate: false\n",
    ],
)
def test_every_way_to_write_the_yaml(tmp_path, yaml):
    grid = load(tmp_path, yaml)
    assert grid.cells.tolist() == CELLS
    assert (grid.resolution, grid.origin.x, grid.origin.y, grid.origin.yaw) == (0.05, -1.5, 2.0, 0.25)


@pytest.mark.parametrize(
    "image",
    [
        b"P5\n2 2\n255\n" + GREYS,
        b"P5 2 2 255 " + GREYS,
        b"P5\n# CREATOR: map_saver 0.050 m/pix\n2 2\n# another\n255\n" + GREYS,
        b"P5\n2 # width\n2#height\n255\n" + GREYS,
        b"P2\n# plain\n2 2\n255\n0 254\n205 # in the pixels, too\n100\n",
        b"P2 2 2 255 0 254 205 100",
        b"P5\n2 2\n65535\n" + struct.pack(">4H", 0, 254 * 257, 205 * 257, 100 * 257),
        b"P6\n2 2\n255\n" + bytes(v for g in GREYS for v in (g, g, g)),
        b"P3\n2 2\n255\n" + b" ".join(b"%d %d %d" % (g, g, g) for g in GREYS),
        b"P5\n2 2\n255\n" + GREYS + b"\ntrailing",
    ],
)
def test_every_form_of_a_pnm_image(tmp_path, image):
    assert load(tmp_path, YAML, image).cells.tolist() == CELLS


def test_the_image_is_looked_for_beside_the_yaml_or_where_its_path_says(tmp_path):
    assert load(tmp_path, YAML.replace("m.pgm", "'maps/floor #1.pgm'"), name="maps/floor #1.pgm").width == 2
    absolute = tmp_path / "elsewhere" / "m.pgm"
    assert load(tmp_path, YAML.replace("m.pgm", f'"{absolute}"'), name="elsewhere/m.pgm").width == 2


def test_negate_turns_light_and_dark(tmp_path):
    assert load(tmp_path, YAML + "negate: 1\n").cells.tolist() == [[100, -1], [0, 100]]


def test_thresholds_decide_what_is_free_and_occupied(tmp_path):
    yaml = YAML + "occupied_thresh: 0.5\nfree_thresh: 0.3\n"
    assert load(tmp_path, yaml).cells.tolist() == [[0, 100], [100, 0]]


def test_mode_scale_keeps_what_lies_between(tmp_path):
    cells = load(tmp_path, YAML + "mode: scale\nfree_thresh: 0.1\n").cells
    assert cells[1].tolist() == [100, 0]
    assert cells[0].tolist() == [int(99 * (50 / 255 - 0.1) / 0.55), int(99 * (155 / 255 - 0.1) / 0.55)]


def test_mode_raw_is_the_image_itself_whatever_the_thresholds(tmp_path):
    image = b"P5\n2 2\n255\n" + bytes([0, 100, 50, 255])
    assert load(tmp_path, YAML + "mode: raw\nfree_thresh: 100\n", image).width == 2
    assert load(tmp_path, YAML + "mode: raw\n", image).cells.tolist() == [[50, -1], [0, 100]]


@pytest.mark.parametrize(
    ("yaml", "image", "match"),
    [
        (YAML.replace("0.05", "0"), None, r"m\.yaml.*resolution"),
        (YAML.replace("0.05", "five"), None, "resolution 'five' is not a number"),
        (YAML.replace("0.25]", "]"), None, "three numbers"),
        (YAML.replace("0.25", "nan"), None, "finite"),
        ("image: m.pgm\n", None, "no origin, resolution"),
        ("{not a map\n", None, "not a line of a map file"),
        (YAML + "mode: odd\n", None, "trinary, scale, raw"),
        (YAML + "negate: perhaps\n", None, "neither 0 nor 1"),
        (YAML.replace("m.pgm", "'m.pgm"), None, "closing '"),
        (YAML + "free_thresh: 19.6\noccupied_thresh: 65\n", None, r"m\.yaml: free_thresh 19\.6 .* < 1"),
        (YAML + "occupied_thresh: 1.0\n", None, "occupied_thresh 1.0 would lose walls"),
        (YAML + "occupied_thresh: 0.196\nfree_thresh: 0.65\n", None, "0 <= free_thresh <= occupied_thresh"),
        (YAML + "free_thresh: -0.1\n", None, "free_thresh -0.1"),
        (YAML + "mode: scale\noccupied_thresh: 0.1\n", None, "free_thresh 0.196 and occupied_thresh 0.1"),
        (YAML.replace("0.25", "90"), None, "yaw 90.0 .* radians: 90.0 degrees are 1.570796"),
        (YAML.replace("0.25", "-6.3"), None, "yaw -6.3 is more than one turn"),
        (YAML, b"P5\n2 2\n255\nab", "cut short"),
        (YAML, b"P2\n2 2\n255\n0 1 2", "cut short"),
        (YAML, b"P2\n2 2\n255\n0 1 2 x", "not a number"),
        (YAML, b"P2\n2 2\n255\n0 1 2 256", "larger than the announced"),
        (YAML, b"P5\n100000 100000\n255\n", "at most"),
        (YAML, b"P5\n-2 2\n255\n" + GREYS, "neither PGM"),
        (YAML, b"BM not a map", "neither PGM"),
        (YAML, b"", "neither PGM"),
        (YAML, b"\x89PNG\r\n\x1a\n", "no header"),
    ],
)
def test_a_broken_map_says_which_file_and_what_is_wrong(tmp_path, yaml, image, match):
    with pytest.raises(ValueError, match=match) as caught:
        load(tmp_path, yaml, *([] if image is None else [image]))
    assert str(tmp_path) in str(caught.value)


def test_a_missing_image_is_named(tmp_path):
    (tmp_path / "m.yaml").write_text(YAML)
    with pytest.raises(FileNotFoundError, match=r"m\.pgm"):
        GridMap.load(tmp_path / "m.yaml")


def test_a_threshold_that_makes_the_unknown_free_is_told(tmp_path, caplog):
    """nav2's map_saver wrote 0.25 beside map_saver's grey 205."""
    assert load(tmp_path, YAML + "free_thresh: 0.25\n").cells.tolist() == [[0, -1], [100, 0]]
    assert "0.25 makes 1 cells free that map_saver wrote as unknown" in caplog.text
    caplog.clear()
    load(tmp_path, YAML + "free_thresh: 0.25\n", b"P5\n2 2\n255\n" + bytes([0, 254, 200, 100]))
    load(tmp_path, YAML + "free_thresh: 0.25\nmode: scale\n")
    assert not caplog.text


# -- names ---------------------------------------------------------------------------------------------------

GRID = GridMap(np.array(CELLS, np.int8), 0.05, Pose2D(-1.5, 2.0, 0.25))
WINDOWS_REFUSES = set('<>:"/\\|?*')


@pytest.mark.parametrize(
    "name",
    [
        "hall #2", "'q", "it's #3", "[1]", "[1", "a: b", "- x", "%TAG", "{x}", "&a", "*a", "!a", "|", ">", "@", "`",
        '"', 'a"b #c', '" #c', 'say "x"', " blank ", "~", "true", "12", "-1", "---", "...", "#", "a\\tb", "?", "é: ü", "大厅",
    ],
)  # fmt: skip
def test_a_saved_map_of_any_name_is_read_again_here_and_by_yaml(tmp_path, name):
    if sys.platform == "win32" and (WINDOWS_REFUSES & set(name) or name.endswith((" ", "."))):
        pytest.skip("Windows does not allow this name of a file")
    sheet, image = GRID.save(tmp_path / name)
    assert (sheet.name, image.name) == (f"{name}.yaml", f"{name}.pgm")
    assert GridMap.load(sheet).cells.tolist() == CELLS
    yaml = pytest.importorskip("yaml")
    assert yaml.safe_load(sheet.read_text("utf-8"))["image"] == image.name


@pytest.mark.parametrize("name", ["hall.v2", "hall.2026-01-01", "hall.yaml.old", "hall.PGM"])
def test_a_dot_in_a_name_does_not_end_it(tmp_path, name):
    """hall.yaml, another map, was overwritten."""
    before = GRID.save(tmp_path / "hall")
    sheet, image = GRID.save(tmp_path / name)
    assert {sheet.name, image.name} == {f"{name}.yaml", f"{name}.pgm"}
    assert len({sheet, image, *before}) == 4


@pytest.mark.parametrize("name", ["hall", "hall.yaml", "hall.yml", "hall.pgm", "hall.png"])
def test_the_endings_of_the_files_are_not_part_of_the_name(tmp_path, name):
    assert GRID.save(tmp_path / name) == (tmp_path / "hall.yaml", tmp_path / "hall.pgm")


def test_a_map_saved_as_png_is_a_picture_too(tmp_path):
    GRID.save(tmp_path / "hall.png")
    assert (tmp_path / "hall.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", ["a\nb", "a\tb", "\udcff", "."])
def test_a_name_that_cannot_be_written_is_refused_before_anything_is_written(tmp_path, name):
    with pytest.raises(ValueError, match="cannot be the name of a map"):
        GRID.save(Path(name) if name == "." else tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("written", "name"),
    [
        ("'it''s.pgm'", "it's.pgm"),
        ('"a\\u0301.pgm"', "a\u0301.pgm"),
        ("Tom's.pgm  # the hall's", "Tom's.pgm"),
        (r'"C:\maps\new.pgm"', r"C:\maps\new.pgm"),
        (r'"C:\temp\new.pgm"', r"C:\temp\new.pgm"),
    ],
)
def test_quotes_and_escapes_as_in_yaml_and_paths_of_windows(tmp_path, written, name):
    (tmp_path / "m.yaml").write_text(YAML.replace("m.pgm", written), encoding="utf-8")
    with pytest.raises(OSError) as caught:
        GridMap.load(tmp_path / "m.yaml")
    assert Path(caught.value.filename) == tmp_path / name


# -- PNG -------------------------------------------------------------------------------------------------------


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(width, height, depth, kind, rows, *, palette=b"", interlaced=0):
    head = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, interlaced)
    data = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head)
    data += chunk(b"PLTE", palette) if palette else b""
    packed = zlib.compress(b"".join(rows))
    return data + chunk(b"IDAT", packed[:5]) + chunk(b"IDAT", packed[5:]) + chunk(b"IEND", b"")


def filtered(kind, row, above, step):
    """One row as an encoder would write it (the definition in the specification, byte by byte)."""
    out = [kind]
    for i, value in enumerate(row):
        a, b = (row[i - step] if i >= step else 0), above[i]
        c = above[i - step] if i >= step else 0
        p = a + b - c
        nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
        out.append((value - {0: 0, 1: a, 2: b, 3: (a + b) // 2, 4: nearest}[kind]) % 256)
    return bytes(out)


@pytest.mark.parametrize(("kind", "channels"), [(0, 1), (2, 3), (4, 2), (6, 4)])
def test_all_filters_and_colour_types(kind, channels):
    pixels = np.random.default_rng(7).integers(0, 256, (10, 7, channels), dtype=np.uint8)
    rows, above = [], bytes(7 * channels)
    for number, row in enumerate(pixels.reshape(10, -1)):
        rows.append(filtered(number % 5, row.tolist(), above, channels))
        above = row.tolist()
    assert (decode_png(png(7, 10, 8, kind, rows), 1000) == pixels).all()


def test_small_and_large_samples_and_palettes():
    assert decode_png(png(3, 1, 1, 0, [b"\0\xa0"]), 10)[0, :, 0].tolist() == [255, 0, 255]
    assert decode_png(png(3, 1, 2, 0, [b"\0\x1b"]), 10)[0, :, 0].tolist() == [0, 85, 170]
    assert decode_png(png(2, 1, 4, 0, [b"\0\xf1"]), 10)[0, :, 0].tolist() == [255, 17]
    assert decode_png(png(2, 1, 16, 0, [b"\0\x12\x34\xff\xff"]), 10)[0, :, 0].tolist() == [0x12, 255]
    palette = bytes([1, 2, 3, 4, 5, 6])
    assert decode_png(png(2, 1, 8, 3, [b"\0\1\0"], palette=palette), 10)[0].tolist() == [[4, 5, 6], [1, 2, 3]]


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (png(2, 1, 8, 0, [b"\0\1\2"], interlaced=1), "interlaced"),
        (png(2, 1, 8, 3, [b"\0\1\2"], palette=b"\1\2\3"), "palette"),
        (png(2, 2, 8, 0, [b"\0\1\2"]), "cut short"),
        (png(2, 1, 8, 0, [b"\7\1\2"]), "filter 7"),
        (png(200, 100, 8, 0, [b"\0"]), "expected 1 to"),
        (png(2, 1, 8, 5, [b"\0\1\2"]), "colour type 5"),
        (png(2, 1, 8, 0, [b"\0\1\2"])[:40], "cut short"),
    ],
)
def test_a_broken_picture_says_what_is_wrong(data, match):
    with pytest.raises(ValueError, match=match):
        decode_png(data, 1000)


def test_a_map_with_a_png_is_the_same_map(tmp_path):
    rows = [b"\0" + GREYS[:2], b"\0" + GREYS[2:]]
    grid = load(tmp_path, YAML.replace("m.pgm", "m.png"), png(2, 2, 8, 0, rows), name="m.png")
    assert grid.cells.tolist() == CELLS
    grid.save_png(tmp_path / "again.png")
    assert decode_png((tmp_path / "again.png").read_bytes(), 10)[:, :, 0].tolist() == [[0, 254], [205, 205]]


def test_transparency_as_map_server_counts_it(tmp_path):
    """image_loader averages the alpha with the colours in trinary mode: 205 with full alpha becomes free."""
    pixels = b"\0" + bytes([205, 205, 205, 255]) + bytes([0, 0, 0, 255])
    yaml = YAML.replace("m.pgm", "m.png")
    assert load(tmp_path, yaml, png(2, 1, 8, 6, [pixels]), name="m.png").cells.tolist() == [[0, 100]]
    unseen = b"\0" + bytes([128, 128, 128, 0]) + bytes([128, 128, 128, 255])
    cells = load(tmp_path, yaml + "mode: scale\n", png(2, 1, 8, 6, [unseen]), name="m.png").cells
    assert cells[0, 0] == -1
    assert 0 < cells[0, 1] < 99


def test_a_robots_picture_of_very_many_rows_is_refused():
    """Each row takes some microseconds: a narrow one of the allowed size would take ten minutes."""
    with pytest.raises(ValueError, match="rows of pixels; expected at most"):
        cells_of_picture(png(1, 1 << 20, 8, 0, [b"\0\0"]))
