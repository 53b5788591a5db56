"""The pictures of README: small enough for a first screen, and made of what a terminal was told."""

from __future__ import annotations

import struct

import pytest

from tools import pictures

MAX_BYTES = 150_000


@pytest.mark.parametrize("name", pictures.MAKERS)
def test_a_picture_is_there_and_small(name: str) -> None:
    data = (pictures.folder / f"{name}.png").read_bytes()
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    assert len(data) < MAX_BYTES
    width, height = struct.unpack(">II", data[16:24])
    assert 300 < width <= 1280
    assert 200 < height <= 844


def test_every_picture_of_the_pages_can_be_taken_again_and_is_shown() -> None:
    """Except Lichtblick's window, a program of others."""
    made = {f"{name}.png" for name in pictures.MAKERS}
    assert {path.name for path in pictures.folder.glob("*.png")} == made | {"lichtblick.png"}
    pages = "".join(path.read_text("utf-8") for path in pictures.folder.parents[1].glob("*.md"))
    pages += "".join(path.read_text("utf-8") for path in pictures.folder.parent.rglob("*.md"))
    assert {name for name in made if f"pictures/{name}" not in pages} == set()


def test_an_unknown_name_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert pictures.main(["web-fone"]) == 2
    assert "web-fone: not one of map, watch, web" in capsys.readouterr().err


def test_the_last_whole_screen_is_taken() -> None:
    """Not one that was cut off when the program left."""
    screens = "".join(f"\x1b[Hpicture {n}\x1b[K\r\n\x1b[31mend {n}\x1b[0m\x1b[K\x1b[J" for n in (1, 2))
    assert pictures.last_frame(f"\x1b[2J{screens}\x1b[Hpicture 3\x1b[K\r\n") == [
        "picture 2",
        "\x1b[31mend 2\x1b[0m",
    ]


def test_no_screen_is_an_error() -> None:
    with pytest.raises(ValueError, match="no screen in 'woosh: "):
        pictures.last_frame("woosh: connection refused")


def test_colours_become_spans_and_signs_are_escaped() -> None:
    page = pictures.page_of(["\x1b[34;1m<ready>\x1b[0m & more", "plain"])
    assert '<span style="color:#6cb6ff;font-weight:bold">&lt;ready&gt;</span> &amp; more\nplain</pre>' in page
