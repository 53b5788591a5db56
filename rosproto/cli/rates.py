"""Rate, delay and bandwidth of a stream of messages, and the lines `rostopic hz|delay|bw` print for them."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Bandwidth", "Statistics", "Window", "bandwidth_text", "delay_text", "hz_text", "table"]


@dataclass(frozen=True, slots=True)
class Statistics:
    """Of the last values of a window: all in the values' own unit (seconds, bytes)."""

    mean: float
    least: float
    most: float
    deviation: float
    count: int


class Window:
    """The last `size` values; the figures people ask of them.

    Args:
        size: Values kept, the oldest go first.
    """

    def __init__(self, size: int = 50_000) -> None:
        self._values: deque[float] = deque(maxlen=max(1, size))
        self._last: float | None = None
        self.fresh = False

    @property
    def empty(self) -> bool:
        """Whether there is no value yet."""
        return not self._values

    def add(self, value: float) -> None:
        """One value: a delay in seconds, a size in bytes."""
        self._values.append(value)
        self.fresh = True

    def tick(self, now: float) -> None:
        """A message arrived at `now` (seconds): the interval since the one before is the value.

        A clock that jumps back (simulated time restarted) begins the window anew.
        """
        if self._last is not None and now >= self._last:
            self.add(now - self._last)
        elif self._last is not None:
            self._values.clear()
        self._last = now

    def statistics(self) -> Statistics | None:
        """The window's figures; None before the first value. Marks them as seen."""
        self.fresh = False
        if not self._values:
            return None
        mean = math.fsum(self._values) / len(self._values)
        deviation = math.sqrt(math.fsum((v - mean) ** 2 for v in self._values) / len(self._values))
        return Statistics(mean, min(self._values), max(self._values), deviation, len(self._values))


class Bandwidth:
    """Bytes per second over the last `size` messages."""

    def __init__(self, size: int = 100) -> None:
        self._seen: deque[tuple[float, int]] = deque(maxlen=max(2, size))

    def add(self, now: float, size: int) -> None:
        """A message of `size` bytes arrived at `now` (seconds)."""
        self._seen.append((now, size))

    def per_second(self, now: float) -> float | None:
        """Bytes per second until `now`; None before the second message. Decays when nothing comes."""
        if len(self._seen) < 2 or now <= self._seen[0][0]:
            return None
        return sum(size for _, size in self._seen) / (now - self._seen[0][0])

    @property
    def sizes(self) -> list[int]:
        """Sizes in the window, bytes."""
        return [size for _, size in self._seen]


def hz_text(found: Statistics | None) -> str:
    """What `rostopic hz` prints of intervals between messages."""
    if found is None:
        return "no new messages"
    rate = 1.0 / found.mean if found.mean > 0 else 0.0
    return f"average rate: {rate:.3f}\n{_spread(found)}"


def delay_text(found: Statistics | None) -> str:
    """What `rostopic delay` prints of arrival minus header stamp."""
    return "no new messages" if found is None else f"average delay: {found.mean:.3f}\n{_spread(found)}"


def bandwidth_text(bandwidth: Bandwidth, now: float) -> str | None:
    """What `rostopic bw` prints; None while there is nothing to say."""
    per_second = bandwidth.per_second(now)
    if per_second is None:
        return None
    sizes = bandwidth.sizes
    divisor, unit = (1.0, "B") if per_second < 1e3 else (1e3, "KB") if per_second < 1e6 else (1e6, "MB")
    rate, mean, least, most = (
        f"{value / divisor:.2f}{unit}"
        for value in (per_second, sum(sizes) / len(sizes), min(sizes), max(sizes))
    )
    return f"average: {rate}/s\n\tmean: {mean} min: {least} max: {most} window: {len(sizes)}"


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Left-aligned columns under centred titles, as `rostopic hz` prints for several topics."""
    widths = [max(len(cell) for cell in column) for column in zip(header, *rows, strict=True)]
    lines = ["   ".join(title.center(width) for title, width in zip(header, widths, strict=True))]
    lines.append("=" * (sum(widths) + 3 * (len(widths) - 1)))
    lines += ["   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(lines) + "\n"


def _spread(found: Statistics) -> str:
    return (
        f"\tmin: {found.least:.3f}s max: {found.most:.3f}s "
        f"std dev: {found.deviation:.5f}s window: {found.count + 1}"
    )
