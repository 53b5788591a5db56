"""Common tasks: the frequency of events, the age of stamps, and a heartbeat of the node."""

import threading
from dataclasses import dataclass

import rospy

from ._diagnostic_status_wrapper import ERROR, OK, WARN
from ._diagnostic_updater import DiagnosticTask


@dataclass(eq=False)
class FrequencyStatusParam:
    """The expected frequency: a dict with "min" (and "max") in Hz, a tolerance (0.1 is 10 %), windows.

    The dict is read at every report, so its values may be changed.
    """

    freq_bound: dict
    tolerance: float = 0.1
    window_size: int = 5


class FrequencyStatus(DiagnosticTask):
    """Counts calls of `tick`; warns when they are too rare or too many, an error when there are none."""

    def __init__(self, params, name="FrequencyStatus"):
        super().__init__(name)
        self.params = params
        self.lock = threading.Lock()
        self.clear()

    def clear(self):
        """Start over."""
        with self.lock:
            self.count = 0
            self.hist_indx = 0
            self.times = [rospy.Time.now()] * self.params.window_size
            self.seq_nums = [0] * self.params.window_size

    def tick(self):
        """Count an event."""
        with self.lock:
            self.count += 1

    def run(self, stat):
        """Report what happened since the report `window_size` reports ago."""
        with self.lock:
            now, at = rospy.Time.now(), self.hist_indx
            events = self.count - self.seq_nums[at]
            window = (now - self.times[at]).to_sec()
            rate = events / window
            self.seq_nums[at], self.times[at] = self.count, now
            self.hist_indx = (at + 1) % self.params.window_size
            self._report(stat, events, window, rate)
        return stat

    def _report(self, stat, events, window, rate):
        bounds, tolerance = self.params.freq_bound, self.params.tolerance
        lowest = bounds["min"] * (1 - tolerance)
        highest = bounds["max"] * (1 + tolerance) if "max" in bounds else None
        if not events:
            stat.summary(ERROR, "No events recorded.")
        elif rate < lowest:
            stat.summary(WARN, "Frequency too low.")
        elif highest is not None and rate > highest:
            stat.summary(WARN, "Frequency too high.")
        else:
            stat.summary(OK, "Desired frequency met")
        stat.add("Events in window", events)
        stat.add("Events since startup", self.count)
        numbers = [("Duration of window (s)", window), ("Actual frequency (Hz)", rate)]
        if highest is not None and bounds["min"] == bounds["max"]:
            numbers.append(("Target frequency (Hz)", bounds["min"]))
        if bounds["min"] > 0:
            numbers.append(("Minimum acceptable frequency (Hz)", lowest))
        if highest is not None:
            numbers.append(("Maximum acceptable frequency (Hz)", highest))
        for key, value in numbers:
            stat.add(key, "%f" % value)


@dataclass(eq=False)
class TimeStampStatusParam:
    """How old stamps may be, seconds; negative for the future."""

    min_acceptable: float = -1
    max_acceptable: float = 5


class TimeStampStatus(DiagnosticTask):
    """Compares stamps with the time at which `tick` is called."""

    def __init__(self, params=TimeStampStatusParam(), name="Timestamp Status"):  # noqa: B008
        super().__init__(name)
        self.params = params
        self.lock = threading.Lock()
        self.early_count = self.late_count = self.zero_count = 0
        self._begin()

    def _begin(self):
        self.zero_seen = self.deltas_valid = False
        self.max_delta = self.min_delta = 0

    def tick(self, stamp):
        """Note a stamp: a Time, or float seconds."""
        seconds = stamp if isinstance(stamp, float) else stamp.to_sec()
        with self.lock:
            if seconds == 0:
                self.zero_seen = True
                return
            age = rospy.Time.now().to_sec() - seconds
            self.max_delta = max(self.max_delta, age) if self.deltas_valid else age
            self.min_delta = min(self.min_delta, age) if self.deltas_valid else age
            self.deltas_valid = True

    def run(self, stat):
        """Report the stamps since the last report."""
        with self.lock:
            stat.summary(OK, "Timestamps are reasonable.")
            if self.deltas_valid:
                self._summarize_state(stat)
            else:
                stat.summary(WARN, "No data since last update.")
            for key, seconds in (
                ("Earliest timestamp delay:", self.min_delta),
                ("Latest timestamp delay:", self.max_delta),
                ("Earliest acceptable timestamp delay:", self.params.min_acceptable),
                ("Latest acceptable timestamp delay:", self.params.max_acceptable),
            ):
                stat.add(key, "%f" % seconds)
            stat.add("Late diagnostic update count:", self.late_count)
            stat.add("Early diagnostic update count:", self.early_count)
            stat.add("Zero seen diagnostic update count:", self.zero_count)
            self._begin()
        return stat

    def _summarize_state(self, stat):
        """Set the summary; of several problems the last one is reported."""
        if self.min_delta < self.params.min_acceptable:
            stat.summary(ERROR, "Timestamps too far in future seen.")
            self.early_count += 1
        if self.max_delta > self.params.max_acceptable:
            stat.summary(ERROR, "Timestamps too far in past seen.")
            self.late_count += 1
        if self.zero_seen:
            stat.summary(ERROR, "Zero timestamp seen.")
            self.zero_count += 1


class Heartbeat(DiagnosticTask):
    """Always OK: shows that the node runs."""

    def __init__(self):
        super().__init__("Heartbeat")

    def run(self, stat):
        """Report OK."""
        stat.summary(OK, "Alive")
        return stat
