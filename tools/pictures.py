"""The pictures of README and docs/, taken from a simulated chassis.

`python -m tools.pictures` takes all of them, `python -m tools.pictures web-phone qt` those named. watch.png
is what `woosh watch` shows in a terminal, map.png is written by `woosh map save`, qt.png is the window of
examples/embedding/qt_window.py, and the others are the page of `woosh web` in a browser. Needs a Unix
terminal, Chromium, a font with Chinese characters, and
`pip install ".[web]" playwright "PySide6-Essentials!=6.12.0"`.
"""

from __future__ import annotations

import html
import io
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.geometry import Pose2D
from woosh_pure.maps import MarkFile

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page

__all__ = ["MAKERS", "folder", "last_frame", "main", "page_of"]

folder = Path(__file__).resolve().parents[1] / "docs" / "pictures"
"""Where the pictures are in a source tree."""

COLUMNS, LINES = 104, 30
DESK, PHONE = (1280, 800), (390, 844)
MARKS = {"A1": (3.0, 1.0, 90.0), "B1": (8.5, -2.0, 0.0), "P1": (-0.5, 2.5, 0.0)}
"""Marks of the simulated hall: x and y in m, degrees."""
_CODES = {"31": "#ff6b68", "32": "#7ec699", "33": "#e8c268", "34": "#6cb6ff", "1": "bold", "2": "#8b949e"}
_CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
_PAGE = """<!doctype html><meta charset="utf-8"><style>
body {{ margin: 0; background: #0d1117; color: #d7dde4 }}
pre {{ margin: 14px 16px; font: 14px/17px "DejaVu Sans Mono", monospace }}
</style><pre>{}</pre>
"""


def main(names: Sequence[str] = ()) -> int:
    """Take the pictures with these names, or all; the exit code."""
    if unknown := [name for name in names if name not in MAKERS]:
        print(f"{', '.join(unknown)}: not one of {', '.join(MAKERS)}", file=sys.stderr)
        return 2
    program = next((found for name in _CHROMIUM if (found := shutil.which(name))), None)
    if program is None:
        print(f"none of {', '.join(_CHROMIUM)} is installed; one of them is needed", file=sys.stderr)
        return 1
    from playwright.sync_api import sync_playwright

    folder.mkdir(exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        for name in names or MAKERS:
            picture = folder / f"{name}.png"
            with tempfile.TemporaryDirectory() as work:
                picture.write_bytes(MAKERS[name](browser, Path(work)))
            print(f"{picture}: {picture.stat().st_size:,} bytes")
        browser.close()
    return 0


# -- a terminal, and the command that draws a map ------------------------------------------------------------


def keep_marks(work: Path) -> None:
    """Write the user's marks of the commands that are run."""
    marks = MarkFile(work / "marks.json")
    for mark, (x, y, degrees) in MARKS.items():
        marks.put(mark, Pose2D(x, y, math.radians(degrees)))
    marks.save()


def map_picture(_: Browser, work: Path) -> bytes:
    """The map of a robot on its way to a mark."""
    keep_marks(work)
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis:
        chassis.go_to_mark("B1")
        chassis.pose.wait_for(lambda pose: pose.x > 1.5, timeout=60)
        run_woosh(work, sim.master_uri, ["map", "save", str(work / "map")])
    return (work / "map.png").read_bytes()


def watch_picture(browser: Browser, work: Path) -> bytes:
    """The terminal's screen of `woosh watch` when the robot leaves."""
    keep_marks(work)
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis:
        words = ["watch", "--for", "8"]
        shown = last_frame(run_woosh(work, sim.master_uri, words, begun=lambda: chassis.go_to_mark("B1")))
    page = browser.new_page(viewport={"width": round(COLUMNS * 8.43) + 32, "height": LINES * 17 + 28})
    page.set_content(page_of(shown))
    return page.screenshot()


def run_woosh(work: Path, uri: str, words: Sequence[str], begun: Callable[[], object] = lambda: None) -> str:
    """The output of the command in its own terminal.

    Args:
        begun: Called when the first screen has been drawn.

    Raises:
        RuntimeError: It failed, or did not end within a minute.
    """
    if sys.platform == "win32":
        raise RuntimeError(
            "the picture of a terminal is made where there are pseudo-terminals: not on Windows"
        )
    import fcntl
    import pty
    import struct
    import termios

    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", LINES, COLUMNS, 0, 0))
    environment = {**os.environ, "WOOSH_CONFIG_DIR": str(work), "TERM": "xterm-256color", "LANG": "C.UTF-8"}
    command = [sys.executable, "-m", "woosh_pure", "--master", uri, "--lang", "en", *words]
    for name in ("NO_COLOR", "LC_ALL", "COLUMNS", "LINES"):
        environment.pop(name, None)
    with subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, env=environment) as program:
        os.close(theirs)
        written = b""
        for piece in _all_of(ours, program, time.monotonic() + 60.0):
            if b"\x1b[H" in piece and b"\x1b[H" not in written:
                begun()
            written += piece
    os.close(ours)
    if program.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} ended with {program.returncode}:\n{written.decode()}")
    return written.decode()


def _all_of(terminal: int, program: subprocess.Popen[bytes], end: float) -> Iterator[bytes]:
    """The output until the program closes the terminal; it is killed after the timeout."""
    import select

    while select.select([terminal], [], [], max(0.0, end - time.monotonic()))[0]:
        try:
            piece = os.read(terminal, 65536)
        except OSError:  # how Linux says that the other end is closed
            return
        if not piece:
            return
        yield piece
    program.kill()


def last_frame(written: str) -> list[str]:
    """The lines, with their colour codes, of the last whole screen in what `woosh watch` wrote.

    Raises:
        ValueError: There is none.
    """
    frames = re.findall(r"\x1b\[H(.*?)\x1b\[K\x1b\[J", written, re.DOTALL)
    if not frames:
        raise ValueError(f"no screen in {written!r}")
    return [line.rstrip() for line in frames[-1].replace("\r", "").replace("\x1b[K", "").split("\n")]


def page_of(lines: Sequence[str]) -> str:
    """Lines with colour codes as an HTML page that looks like a terminal."""
    return _PAGE.format("\n".join(_line(line) for line in lines))


def _line(line: str) -> str:
    parts, opened = [], False
    for index, piece in enumerate(re.split(r"\x1b\[([\d;]*)m", line)):
        if index % 2 == 0:
            parts.append(html.escape(piece))
            continue
        if opened:
            parts.append("</span>")
        style = [_CODES[code] for code in piece.split(";") if code in _CODES]
        opened = bool(style)
        if opened:
            parts.append(f'<span style="{";".join(map(_css, style))}">')
    return "".join(parts) + ("</span>" if opened else "")


def _css(value: str) -> str:
    return "font-weight:bold" if value == "bold" else f"color:{value}"


# -- the page of `woosh web` ---------------------------------------------------------------------------------


@contextmanager
def hall_page(
    browser: Browser, size: tuple[int, int], language: str, scheme: str
) -> Iterator[tuple[Page, Chassis]]:
    """The page of a simulated robot in the built-in hall, with its marks, and the robot."""
    from woosh_pure import web
    from woosh_pure.maps.marks import UserMark
    from woosh_pure.web.server import WebServer

    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis:
        marks = [
            UserMark(name, mark.pose, charger=mark.charger) for name, mark in sim.world.site.marks.items()
        ]
        app = web.app({"sim": chassis}, allow_driving=True, marks=marks, simulator={"sim": sim})
        context = browser.new_context(
            viewport={"width": size[0], "height": size[1]},
            locale=language,
            color_scheme="dark" if scheme == "dark" else "light",
            has_touch=size == PHONE,
            reduced_motion="reduce",
        )
        with WebServer(app, port=0) as server:
            page = context.new_page()
            page.goto(server.url)
            page.wait_for_selector(".markrow")
            yield page, chassis
            context.close()
        web.close(app)


def taken(what: Page | Locator, **options: Any) -> bytes:
    """A screenshot with a palette; rare colours, as of the scan, are kept."""
    from PIL import Image

    written = io.BytesIO()
    shown = Image.open(io.BytesIO(what.screenshot(**options))).convert("RGB")
    palette = shown.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE)
    palette.save(written, "PNG", optimize=True)
    return written.getvalue()


def under_way(size: tuple[int, int], language: str, scheme: str) -> Callable[[Browser, Path], bytes]:
    """The whole page while the robot drives to a mark."""

    def take(browser: Browser, _: Path) -> bytes:
        with hall_page(browser, size, language, scheme) as (page, chassis):
            page.click(".markrow >> text=B1")
            page.click("#confirm button[type=submit]")
            chassis.pose.wait_for(lambda pose: pose.x > 3.5, timeout=60)
            return taken(page)

    return take


def hall_picture(browser: Browser, _: Path) -> bytes:
    """The map alone: the hall, its marks, the robot at its start."""
    with hall_page(browser, (1280, 640), "en-US", "light") as (page, chassis):
        chassis.pose.wait(timeout=10)
        page.locator("#pose-text", has_text="x").wait_for()
        return taken(page.locator("#map"))


def pad_picture(browser: Browser, _: Path) -> bytes:
    """The tab Drive while the pad is held forward and to the left."""
    with hall_page(browser, DESK, "en-US", "light") as (page, _chassis):
        page.click("#tabbutton-drive")
        page.click("#drive-on")
        page.check("#warning-check")
        page.click("#warning-yes")
        page.locator(".pad").wait_for()
        page.locator("text=You have control.").wait_for()
        box, column = (page.locator(part).bounding_box() for part in (".pad", "#panel"))
        assert box is not None
        assert column is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        for _attempt in range(10):  # a busy computer holds the page up, which ends the drive: press again
            page.mouse.move(x, y)
            page.mouse.down()
            page.mouse.move(x - box["width"] / 8, y - box["height"] / 3, steps=4)
            page.wait_for_timeout(1500)
            left = round(column["x"])
            clip = {"x": left, "y": 0, "width": DESK[0] - left, "height": DESK[1]}
            picture = taken(page, clip=clip)
            if page.locator(".drivestate.driving").count():
                page.mouse.up()
                return picture
            page.mouse.up()
    raise RuntimeError("the drive was never open: this computer is too busy")


def placing_picture(browser: Browser, _: Path) -> bytes:
    """A place is chosen on the map: pressed where the robot should stand, dragged to where it should look."""
    with hall_page(browser, DESK, "en-US", "light") as (page, _chassis):
        page.click("#choose-place")
        box = page.locator("#canvas").bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] * 0.62, box["y"] + box["height"] * 0.35
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 60, y - 60, steps=4)
        picture = taken(page)
        page.mouse.up()
        return picture


def mission_picture(browser: Browser, work: Path) -> bytes:
    """The tab Missions while a mission asks."""
    with hall_page(browser, DESK, "en-US", "light") as (page, chassis):
        round_ = folder.parents[1] / "examples" / "missions" / "round.mission.toml"
        chassis.missions.files = work / "missions"
        chassis.missions.save("round", chassis.missions.load(round_))
        page.click("#tabbutton-missions")
        page.click("#missions .saved .primary")
        page.click("#confirm [type=submit]")
        page.locator("#mission .question").wait_for(timeout=120_000)
        return taken(page)


# -- a window of Qt ------------------------------------------------------------------------------------------


def qt_picture(_: Browser, work: Path) -> bytes:
    """The example's window, which saves its picture itself when it is told a file."""
    program = folder.parents[1] / "examples" / "embedding" / "qt_window.py"
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "LANG": "C.UTF-8"}
    picture = work / "qt.png"
    subprocess.run(
        [sys.executable, str(program), "--picture", str(picture)], check=True, timeout=120, env=environment
    )
    return picture.read_bytes()


MAKERS: dict[str, Callable[[Browser, Path], bytes]] = {
    "map": map_picture,
    "watch": watch_picture,
    "web": under_way(DESK, "en-US", "light"),
    "web-phone": under_way(PHONE, "en-US", "dark"),
    "web-phone.zh-CN": under_way(PHONE, "zh-CN", "dark"),
    "hall": hall_picture,
    "drive-pad": pad_picture,
    "placing": placing_picture,
    "missions": mission_picture,
    "qt": qt_picture,
}
"""How each picture is taken, by its name."""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
