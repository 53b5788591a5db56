"""The pictures of the terminal in docs/tour.md, taken from the commands while a simulated chassis drives.

`python -m tools.pictures` writes docs/pictures/watch.png (what `woosh watch` shows in a terminal, drawn by
Chromium) and docs/pictures/map.png (as `woosh map save` writes it). Needs a Unix terminal and Chromium.
"""

from __future__ import annotations

import html
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.geometry import Pose2D
from woosh_pure.maps import MarkFile

__all__ = ["folder", "last_frame", "main", "page_of"]

folder = Path(__file__).resolve().parents[1] / "docs" / "pictures"
"""Where the pictures are in a source tree."""

COLUMNS, LINES = 104, 30
MARKS = {"A1": (3.0, 1.0, 90.0), "B1": (8.5, -2.0, 0.0), "P1": (-0.5, 2.5, 0.0)}
"""Marks of the simulated hall: x and y in m, degrees."""
_CODES = {"31": "#ff6b68", "32": "#7ec699", "33": "#e8c268", "34": "#6cb6ff", "1": "bold", "2": "#8b949e"}
_CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
_PAGE = """<!doctype html><meta charset="utf-8"><style>
body {{ margin: 0; background: #0d1117; color: #d7dde4 }}
pre {{ margin: 14px 16px; font: 14px/17px "DejaVu Sans Mono", monospace }}
</style><pre>{}</pre>
"""


def main() -> int:
    """Take both pictures; the exit code."""
    browser = next((found for name in _CHROMIUM if (found := shutil.which(name))), None)
    if browser is None:
        print(f"none of {', '.join(_CHROMIUM)} is installed; one of them is needed", file=sys.stderr)
        return 1
    folder.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        marks = MarkFile(work / "marks.json")
        for mark, (x, y, degrees) in MARKS.items():
            marks.put(mark, Pose2D(x, y, math.radians(degrees)))
        marks.save()
        save_map(work)
        (work / "watch.html").write_text(page_of(watch(work)), "utf-8")
        photograph(browser, work / "watch.html", folder / "watch.png", work)
    for picture in sorted(folder.glob("*.png")):
        print(f"{picture}: {picture.stat().st_size:,} bytes")
    return 0


def save_map(work: Path) -> None:
    """The map of a robot on its way to a mark."""
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis:
        chassis.go_to_mark("B1")
        chassis.pose.wait_for(lambda pose: pose.x > 1.5, timeout=60)
        run_woosh(work, sim.master_uri, ["map", "save", str(work / "map")])
    shutil.copyfile(work / "map.png", folder / "map.png")


def watch(work: Path) -> list[str]:
    """The terminal's screen of `woosh watch` when the robot leaves."""
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis:
        words = ["watch", "--for", "8"]
        return last_frame(run_woosh(work, sim.master_uri, words, begun=lambda: chassis.go_to_mark("B1")))


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


def photograph(browser: str, page: Path, picture: Path, work: Path) -> None:
    """Save a browser's picture of a page."""
    size = f"--window-size={round(COLUMNS * 8.43) + 32},{LINES * 17 + 28}"
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run"]
    profile = f"--user-data-dir={work / 'browser'}"
    subprocess.run(
        [browser, *options, profile, size, f"--screenshot={picture}", page.as_uri()],
        check=True, capture_output=True, timeout=60,
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
