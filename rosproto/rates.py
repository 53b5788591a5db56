"""Rate, delay and bandwidth of a topic, and the output of `rostopic hz|delay|bw`.

`rosproto topic` and the `rostopic` module of the rospy layer use it. The caller passes the time, because
their clocks differ.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import NamedTuple

__all__ = ["Bandwidth", "Statistics", "Window", "bandwidth_text", "delay_text", "hz_table", "hz_text"]

_COLUMNS = ("topic", "rate", "min_delta", "max_delta", "std_dev", "window")


class Statistics(NamedTuple):
    """Statistics of the values in a window, in seconds.

    Attributes:
        messages: Number of messages; the first one gave no value.
    """

    mean: float
    minimum: float
    maximum: float
    deviation: float
    messages: int

    @property
    def rate(self) -> float:
        """Messages per second, where the values are intervals."""
        return 1.0 / self.mean if self.mean > 0 else 0.0


class Window:
    """The intervals between the latest messages, or their delays.

    Args:
        messages: Size of the window, in messages; it holds one value less.

    Attributes:
        values: Seconds.
        last: Arrival of the latest message, seconds; 0 before the first.
    """

    def __init__(self, messages: int = 50_000) -> None:
        self.values: deque[float] = deque(maxlen=max(0, messages - 1))
        self.last = 0.0
        self._first: float | None = None
        self._reported = 0.0

    @property
    def fresh(self) -> bool:
        """Whether a message has arrived since the last `statistics`."""
        return bool(self.values) and self.last != self._reported

    def add(self, now: float, delay: float | None = None) -> None:
        """Add a message that arrived at `now` (seconds): its delay if given, else the interval since the
        previous one.

        The first message gives no value, because a latched message may be old. If the clock jumps back to
        before the first message (simulated time restarted), the window starts anew.
        """
        if self._first is None or now < self._first:
            self._first = now
            self.values.clear()
        else:
            self.values.append(now - self.last if delay is None else delay)
        self.last = now

    def statistics(self) -> Statistics | None:
        """Statistics of the window; None before the first value. Marks them as seen."""
        self._reported = self.last
        values = self.values
        if not values:
            return None
        mean = math.fsum(values) / len(values)
        deviation = math.sqrt(math.fsum((v - mean) ** 2 for v in values) / len(values))
        return Statistics(mean, min(values), max(values), deviation, len(values) + 1)

    def news(self) -> Statistics | None:
        """As `statistics`; None if no message has arrived since."""
        return self.statistics() if self.fresh else None


class Bandwidth:
    """Bytes per second over the last `messages` messages.

    Attributes:
        times: Arrival times, seconds.
        sizes: Lengths, bytes.
    """

    def __init__(self, messages: int = 100) -> None:
        self.times: list[float] = []
        self.sizes: list[int] = []
        self._most = messages

    def add(self, now: float, size: int) -> None:
        """A message of `size` bytes arrived at `now` (seconds)."""
        self.times.append(now)
        self.sizes.append(size)
        if len(self.times) > self._most:
            del self.times[0], self.sizes[0]

    def per_second(self, now: float) -> float | None:
        """Bytes per second until `now`; None before the second message. Decays while nothing arrives."""
        if len(self.times) < 2 or now <= self.times[0]:
            return None
        return sum(self.sizes) / (now - self.times[0])


def hz_text(found: Statistics | None) -> str:
    """The output of `rostopic hz`."""
    return "no new messages" if found is None else f"average rate: {found.rate:.3f}\n{_spread(found)}"


def delay_text(found: Statistics | None) -> str:
    """The output of `rostopic delay`: arrival minus header stamp."""
    return "no new messages" if found is None else f"average delay: {found.mean:.3f}\n{_spread(found)}"


def bandwidth_text(bandwidth: Bandwidth, now: float) -> str | None:
    """The output of `rostopic bw`; None before there are values."""
    per_second = bandwidth.per_second(now)
    if per_second is None:
        return None
    sizes = bandwidth.sizes
    divisor, unit = (1.0, "B") if per_second < 1e3 else (1e3, "KB") if per_second < 1e6 else (1e6, "MB")
    rate, mean, minimum, maximum = (
        f"{value / divisor:.2f}{unit}"
        for value in (per_second, sum(sizes) / len(sizes), min(sizes), max(sizes))
    )
    return f"average: {rate}/s\n\tmean: {mean} min: {minimum} max: {maximum} window: {len(sizes)}"


def hz_table(found: Mapping[str, Statistics | None]) -> str:
    """The output of `rostopic hz` for several topics: left-aligned columns under centred titles."""
    rows = [
        (topic, *(f"{v:.4}" for v in (s.rate, s.minimum, s.maximum, s.deviation)), str(s.messages))
        for topic, s in found.items()
        if s is not None
    ]
    if not rows:
        return hz_text(None)
    widths = [max(len(cell) for cell in column) for column in zip(_COLUMNS, *rows, strict=True)]
    lines = ["   ".join(title.center(width) for title, width in zip(_COLUMNS, widths, strict=True))]
    lines.append("=" * (sum(widths) + 3 * (len(widths) - 1)))
    lines += ["   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(lines) + "\n"


def _spread(found: Statistics) -> str:
    return (
        f"\tmin: {found.minimum:.3f}s max: {found.maximum:.3f}s "
        f"std dev: {found.deviation:.5f}s window: {found.messages}"
    )
