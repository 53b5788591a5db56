"""The full-screen display of `woosh watch`: collects the state of a chassis and lays it out as text."""

from __future__ import annotations

import itertools
import math
import textwrap
import time
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from rosproto.errors import RosError
from rosproto.text import cut, printable, width
from woosh_pure.enums import TaskState
from woosh_pure.faults import StatusCode
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.readings import known_path, scan_in_map
from woosh_pure.reasons import Readiness
from woosh_pure.values.state import Battery, RobotStatus

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from woosh_pure.chassis import Chassis

_PANEL = 34
_NARROW = 72
_LOW = 14
_MIN_REASON_LINES = 3
"""Lines of each reason, however little room there is."""
_AROUND = 6.0
"""Metres shown in each direction where there is no map."""
_COLOURS = {"red": "31;1", "green": "32", "yellow": "33", "blue": "34;1", "dim": "2", "bold": "1"}
_SIGNS = {
    "wall": ("█", "#"),
    "unknown": ("░", ":"),
    "scan": ("•", "*"),
    "path": ("·", "."),
    "robot": ("→↗↑↖←↙↓↘", ">/^\\</v\\"),
    "full": ("█", "#"),
    "empty": ("░", "-"),
}
"""What is drawn, and its form in ASCII."""

Piece = tuple[str, str]
"""A text and the name of its colour, "" for none."""


class Screen:
    """Draws scenes. Caches the drawn map, which takes longest.

    Args:
        ascii_only: For terminals without block characters.
        coloured: With colours.
    """

    def __init__(self, *, ascii_only: bool = False, coloured: bool = True) -> None:
        self._signs = {name: pair[ascii_only] for name, pair in _SIGNS.items()}
        self._ascii, self._coloured = ascii_only, coloured
        self._ground: tuple[object, NDArray[np.str_]] | None = None

    def render(self, scene: Scene, columns: int, lines: int) -> list[str]:
        """Return at most `lines` lines of at most `columns` visible characters."""
        title = _title(scene.master_uri, columns)
        body = max(1, lines - 1)
        narrow = columns < _NARROW
        # Stacked, each gets a part; a small screen shows only the facts.
        room = body // 2 if narrow and body > _LOW else body
        panel = self._fitting_panel(scene, columns if narrow else _PANEL, room)
        if narrow:
            rows = [*panel, *self._map(scene, columns, body - len(panel))]
        else:
            rows = self._side_by_side(self._map(scene, columns - _PANEL - 1, body), panel, body)
        return [self._text(row, columns) for row in [title, *rows][:lines]]

    def _side_by_side(
        self, left: list[list[Piece]], right: list[list[Piece]], rows: int
    ) -> list[list[Piece]]:
        gap: Piece = (" ", "")
        padded = right[:rows] + [[] for _ in range(rows - len(right))]
        return [[*a, gap, *b] for a, b in zip(left, padded, strict=True)]

    def _text(self, pieces: Iterable[Piece], columns: int) -> str:
        out, left = [], columns
        for text, colour in pieces:
            shown = cut(printable(text), left)
            left -= width(shown)
            if self._ascii:
                shown = shown.replace("°", "d").replace("²", "2").encode("ascii", "replace").decode()
            out.append(f"\x1b[{_COLOURS[colour]}m{shown}\x1b[0m" if colour and self._coloured else shown)
        return "".join(out)

    # -- the panel -------------------------------------------------------------------------------------------

    def _fitting_panel(self, scene: Scene, columns: int, room: int) -> list[list[Piece]]:
        """Fit the panel; the reasons have priority over the rates."""
        texts = [] if scene.readiness is None else [reason.text for reason in scene.readiness.reasons]
        max_lines = max((len(_wrapped(text, columns)) for text in texts), default=0)
        for reason_lines in range(min(max_lines, room), _MIN_REASON_LINES, -1):
            panel = list(self._panel(scene, columns, reason_lines))
            if len(_without_rates(panel)) <= room:
                return _squeezed(panel, room)
        return _squeezed(list(self._panel(scene, columns, _MIN_REASON_LINES)), room)

    def _panel(self, scene: Scene, columns: int, reason_lines: int) -> Iterable[list[Piece]]:
        yield from self._readiness(scene, columns, reason_lines)
        yield self._fact("pose", None if scene.pose is None else _pose(scene.pose), scene, "pose")
        v = scene.velocity
        moving = None if v is None else f"{v.vx:+.2f} m/s {math.degrees(v.wz):+.0f}°/s"
        yield self._fact("velocity", moving, scene, "velocity")
        yield from self._battery(scene)
        s = scene.status
        yield self._fact("state", None if s is None else f"{s.robot_state}, {s.robot_mode}")
        if s is not None and s.task_state is not TaskState.UNDEFINED:
            yield self._fact("task", f"{s.task_id} {s.task_type} {s.task_state}")
        if s is not None and s.destination:
            yield self._fact("to", s.destination)
        near = None if scene.nearest is None else f"nearest {scene.nearest:.2f} m"
        yield self._fact("scan", near, scene, "scan")
        yield self._fact("odometer", None if scene.odometer is None else f"{scene.odometer:.1f} m")
        yield []
        yield from self._faults(scene)
        yield []
        yield [("rates", "bold"), (" per second", "dim")]
        for name, rate in sorted(scene.rates.items()):
            yield [(f"  {name:13s} {rate:5.1f}", "")]

    def _readiness(self, scene: Scene, columns: int, reason_lines: int) -> Iterable[list[Piece]]:
        if scene.silence is not None:
            yield [(f"SILENT for {scene.silence:.0f} s", "red")]
            yield [("whether it is ready is not known", "yellow")]
            return
        if not scene.ages:
            yield [("nothing heard yet", "yellow")]
        readiness = scene.readiness
        if readiness is None:
            return
        words = {"yes": ("ready", "green"), "no": ("NOT READY", "red")}
        yield [words.get(readiness.answer.value, ("READY? NOT KNOWN", "yellow"))]
        for reason in readiness.reasons:
            for line in _wrapped(reason.text, columns)[:reason_lines]:
                yield [(f"  {line}", "red" if reason.blocking else "yellow" if reason.doubt else "dim")]
        if any(len(_wrapped(reason.text, columns)) > reason_lines for reason in readiness.reasons):
            yield [("  more is in: woosh ready", "bold")]

    def _fact(self, name: str, text: str | None, scene: Scene | None = None, feed: str = "") -> list[Piece]:
        label: Piece = (f"{name:9s}", "dim")
        if text is None:
            return [label, ("not heard", "yellow")]
        age = 0.0 if scene is None else scene.ages.get(feed, 0.0)
        old: list[Piece] = [(f" {age:.0f} s old", "yellow")] if age > 2.0 else []
        return [label, (text, ""), *old]

    def _battery(self, scene: Scene) -> Iterable[list[Piece]]:
        b = scene.battery
        if b is None:
            yield self._fact("battery", None)
            return
        full = round(min(max(b.percent, 0), 100) / 10)
        bar = self._signs["full"] * full + self._signs["empty"] * (10 - full)
        colour = "red" if b.percent < 20 else "yellow" if b.percent < 40 else "green"
        yield [(f"{'battery':9s}", "dim"), (f"{bar} {b.percent} %", colour)]
        if b.measured:
            yield [(f"{'':9s}{b.voltage:.1f} V {b.current:.1f} A", "")]
        if b.charging:
            yield [(f"{'':9s}charging", "green")]

    def _faults(self, scene: Scene) -> Iterable[list[Piece]]:
        if not scene.faults:
            known = getattr(scene.faults, "known", False)
            yield [("faults   ", "dim"), ("none", "") if known else ("not known: none heard", "yellow")]
            return
        yield [("faults", "red")]
        for fault in scene.faults[:5]:
            for line in textwrap.wrap(str(fault), _PANEL - 2)[:3]:
                yield [(f"  {line}", "red" if fault.level >= 3 else "yellow")]

    # -- the map ---------------------------------------------------------------------------------------------

    def _map(self, scene: Scene, columns: int, rows: int) -> list[list[Piece]]:
        """Draw the map; characters are twice as high as wide."""
        if columns < 4 or rows < 2:
            return []
        view = _View(scene, columns, rows)
        signs = self._ground_of(scene.grid, view).copy()
        colours = np.full(signs.shape, "dim", dtype="<U6")
        path = np.array([[p.x, p.y] for p in scene.path]).reshape(-1, 2)
        self._put(signs, colours, view, _dense(path, view.size), self._signs["path"], "blue")
        if scene.scan is not None:
            self._put(signs, colours, view, scene.scan, self._signs["scan"], "yellow")
        pose = scene.pose
        here = np.array([[pose.x, pose.y]]) if pose is not None else np.zeros((1, 2))
        octant = 0 if pose is None else round(pose.yaw / (math.pi / 4.0)) % 8
        self._put(signs, colours, view, here, self._signs["robot"][octant], "red")
        return [_runs(line, tones) for line, tones in zip(signs, colours, strict=True)]

    def _put(
        self,
        signs: NDArray[np.str_],
        colours: NDArray[np.str_],
        view: _View,
        points: NDArray[np.floating],
        sign: str,
        colour: str,
    ) -> None:
        rows, columns = view.cells_of(points)
        signs[rows, columns] = sign
        colours[rows, columns] = colour

    def _ground_of(self, grid: GridMap | None, view: _View) -> NDArray[np.str_]:
        key = (id(grid), view.key)
        if self._ground is None or self._ground[0] != key:
            self._ground = (key, self._draw_ground(grid, view))
        return self._ground[1]

    def _draw_ground(self, grid: GridMap | None, view: _View) -> NDArray[np.str_]:
        empty = " " if grid is None else self._signs["unknown"]
        ground = np.full((view.rows, view.columns), empty, dtype="<U1")
        if grid is None:
            return ground
        for wanted, sign in ((grid.cells == 0, " "), (grid.cells > 50, self._signs["wall"])):
            where = np.argwhere(wanted).astype(np.float64)
            local = (where[:, ::-1] + 0.5) * grid.resolution
            c, s = math.cos(grid.origin.yaw), math.sin(grid.origin.yaw)
            points = local @ np.array([[c, s], [-s, c]]) + np.array([grid.origin.x, grid.origin.y])
            rows, columns = view.cells_of(points)
            ground[rows, columns] = sign
        return ground


def _title(uri: str, columns: int) -> list[Piece]:
    """Return the title; a narrow terminal omits the address first."""
    room = columns - len("woosh watch    q: leave")
    shown = uri if len(uri) <= room else uri.removeprefix("http://").rstrip("/")[: max(0, room)]
    return [("woosh watch ", "bold"), (shown, ""), ("   q: leave", "dim")]


def _squeezed(rows: list[list[Piece]], max_rows: int) -> list[list[Piece]]:
    """Reduce to `max_rows` rows, if possible: omit rates first, then blanks, remarks, the odometer."""

    def begins(row: list[Piece], word: str) -> bool:
        return bool(row) and row[0][0].startswith(word)

    rows = rows if len(rows) <= max_rows else _without_rates(rows)
    if len(rows) > max_rows:
        rows = [row for row in rows if row]
    if len(rows) > max_rows:
        rows = [row for row in rows if not (begins(row, "  ") and row[0][1] == "dim")]
    for word in ("odometer", " " * 9, "task", "scan", "velocity"):
        if len(rows) > max_rows:
            rows = [row for row in rows if not begins(row, word)]
    return rows


def _without_rates(rows: list[list[Piece]]) -> list[list[Piece]]:
    return rows[: next((i for i, row in enumerate(rows) if row and row[0][0] == "rates"), len(rows))]


def _wrapped(text: str, columns: int) -> list[str]:
    """Wrap a reason, indented by two columns."""
    return textwrap.wrap(text, max(1, columns - 2))


class _View:
    """The visible part of the map, north up.

    Attributes:
        size: Width of a character, m; it is twice as high.
    """

    def __init__(self, scene: Scene, columns: int, rows: int) -> None:
        self.columns, self.rows = columns, rows
        low_x, high_x, low_y, high_y = _extent(scene)
        self.size = max((high_x - low_x) / columns, (high_y - low_y) / (2.0 * rows))
        self._left = (low_x + high_x - self.size * columns) / 2.0
        self._top = (low_y + high_y + 2.0 * self.size * rows) / 2.0
        self.key = (columns, rows, round(self._left, 3), round(self._top, 3))

    def cells_of(self, points: NDArray[np.floating]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return rows and columns of the visible points (N, 2)."""
        columns = np.floor((points[:, 0] - self._left) / self.size).astype(np.int64)
        rows = np.floor((self._top - points[:, 1]) / (2.0 * self.size)).astype(np.int64)
        inside = (rows >= 0) & (rows < self.rows) & (columns >= 0) & (columns < self.columns)
        return rows[inside], columns[inside]


def _extent(scene: Scene) -> tuple[float, float, float, float]:
    grid = scene.grid
    if grid is None:
        x, y = (0.0, 0.0) if scene.pose is None else (round(scene.pose.x), round(scene.pose.y))
        return x - _AROUND, x + _AROUND, y - _AROUND, y + _AROUND
    corners = [grid.point_of(r, c) for r in (0, grid.height - 1) for c in (0, grid.width - 1)]
    xs, ys, half = [x for x, _ in corners], [y for _, y in corners], grid.resolution / 2.0
    return min(xs) - half, max(xs) + half, min(ys) - half, max(ys) + half


def _dense(corners: NDArray[np.floating], step: float) -> NDArray[np.floating]:
    """Return a point every `step` m along a line, at most 2000."""
    if len(corners) < 2:
        return corners
    ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    at = np.linspace(0.0, ways[-1], min(2000, max(2, math.ceil(ways[-1] / step))))
    return np.stack([np.interp(at, ways, corners[:, 0]), np.interp(at, ways, corners[:, 1])], axis=1)


def _runs(line: NDArray[np.str_], tones: NDArray[np.str_]) -> list[Piece]:
    """Join neighbours of the same colour to a piece."""
    edges = [0, *(np.flatnonzero(tones[1:] != tones[:-1]) + 1).tolist(), len(line)]
    return [("".join(line[a:b]), str(tones[a])) for a, b in itertools.pairwise(edges)]


def _pose(pose: Pose2D) -> str:
    return f"{pose.x:.2f} {pose.y:.2f} m {pose.yaw_degrees:.0f}°"


FEEDS = ("pose", "velocity", "scan", "battery", "status", "plan", "localization", "odometer")


_SILENT = 2.0


@dataclass(slots=True)
class Scene:
    """The state at one time; None or empty without data.

    Attributes:
        scan: (N, 2) m in the map, or in base_link when the pose is not known.
        rates: Messages per second of each feed with data.
        ages: Seconds since the newest message of each feed with data.
    """

    master_uri: str
    pose: Pose2D | None = None
    velocity: Velocity | None = None
    battery: Battery | None = None
    status: RobotStatus | None = None
    readiness: Readiness | None = None
    faults: tuple[StatusCode, ...] = ()
    scan: NDArray[np.floating] | None = None
    nearest: float | None = None
    path: Sequence[Pose2D] = ()
    odometer: float | None = None
    grid: GridMap | None = None
    rates: dict[str, float] = field(default_factory=dict)
    ages: dict[str, float] = field(default_factory=dict)

    @property
    def silence(self) -> float | None:
        """Seconds without any message, if longer than a running chassis is silent; else None."""
        least = min(self.ages.values(), default=0.0)
        return least if least > _SILENT else None


class Observer:
    """Collects a chassis's state. Opens the feeds at once; `fetch_map` fetches the map."""

    def __init__(self, chassis: Chassis) -> None:
        self._chassis = chassis
        self._feeds = {name: chassis.feed(name).open() for name in (*FEEDS, "tf_static")}
        chassis.readiness()
        self._counts: deque[tuple[float, dict[str, int]]] = deque(maxlen=100)
        self.grid: GridMap | None = None

    def fetch_map(self) -> None:
        """Fetch the map; without one, only the scan is drawn."""
        try:
            self.grid = self._chassis.get_map()
        except (RosError, ValueError):
            self.grid = None

    def look(self) -> Scene:
        """Return the present scene."""
        chassis, feeds = self._chassis, self._feeds
        pose, scan = feeds["pose"].latest, feeds["scan"].latest
        return Scene(
            master_uri=chassis.master_uri,
            pose=pose,
            velocity=feeds["velocity"].latest,
            battery=feeds["battery"].latest,
            status=feeds["status"].latest,
            readiness=chassis.readiness(),
            faults=chassis.faults,
            scan=None if scan is None else scan_in_map(chassis, scan, pose),
            nearest=None if scan is None else scan.nearest,
            path=known_path(chassis),
            odometer=feeds["odometer"].latest,
            grid=self.grid,
            rates=self._rates(),
            ages={name: f.age for name, f in feeds.items() if name in FEEDS and f.age is not None},
        )

    def _rates(self) -> dict[str, float]:
        """Return the rates over the last two seconds."""
        now, counts = time.monotonic(), {name: self._feeds[name].count for name in FEEDS}
        self._counts.append((now, counts))
        while len(self._counts) > 2 and now - self._counts[0][0] > 2.0:
            self._counts.popleft()
        since, before = self._counts[0]
        seconds = max(now - since, 1e-3)
        return {name: (count - before[name]) / seconds for name, count in counts.items() if count}
