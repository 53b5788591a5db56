"""diagnostic_updater: what a node says of its health on /diagnostics (wiki.ros.org/diagnostic_updater).

Tasks fill statuses; an Updater runs them at a steady pace and publishes what they say.
"""

import threading

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


def _level_and_text(args):
    if len(args) == 1:
        return args[0].level, args[0].message
    level, text = args
    return level, text


class DiagnosticStatusWrapper(DiagnosticStatus):
    """A DiagnosticStatus; its summary and values are set by methods."""

    def summary(self, *args):
        """Set level and message: by `(level, message)`, or as another status has them."""
        self.level, text = _level_and_text(args)
        self.message = text if len(args) == 1 else str(text)

    def clearSummary(self):
        """OK, and no message."""
        self.summary(OK, "")

    def mergeSummary(self, *args):
        """Add another summary: the worse level; messages of good and bad are not mixed."""
        level, text = _level_and_text(args)
        if bool(level > OK) is bool(self.level > OK):
            self.message = self.message + "; " + text if self.message else text
        elif level > self.level:
            self.message = text
        self.level = max(self.level, level)

    def add(self, key, val):
        """Add a value under a key."""
        self.values.append(KeyValue(key, str(val)))


class DiagnosticTask:
    """Something with a name that fills a status; derive from it, or use FunctionDiagnosticTask."""

    def __init__(self, name):
        self.name = name

    def getName(self):
        """Its name."""
        return self.name

    def run(self, stat):
        """Fill a DiagnosticStatusWrapper and return it."""
        return stat


class FunctionDiagnosticTask(DiagnosticTask):
    """A task that is a function `fn(stat)`, which returns `stat`."""

    def __init__(self, name, fn):
        super().__init__(name)
        self.fn = fn

    def run(self, stat):
        """Call the function."""
        return self.fn(stat)


class CompositeDiagnosticTask(DiagnosticTask):
    """Several tasks that fill one status; their summaries are merged."""

    def __init__(self, name):
        super().__init__(name)
        self.tasks = []

    def addTask(self, t):
        """Run this one too."""
        self.tasks.append(t)

    def run(self, stat):
        """Run each on the status as it was, then set the merged summary."""
        before, merged = DiagnosticStatusWrapper(), DiagnosticStatusWrapper()
        before.summary(stat)
        for task in self.tasks:
            stat.summary(before)
            stat = task.run(stat)
            merged.mergeSummary(stat)
        stat.summary(merged)
        return stat


_NO_HARDWARE = (
    "diagnostic_updater: No HW_ID was set. This is probably a bug. Please report it. For devices that do not "
    "have a HW_ID, set this value to 'none'. This warning only occurs once all diagnostics are OK so it is "
    "okay to wait until the device is open before calling setHardwareID."
)


def _status(name):
    status = DiagnosticStatusWrapper()
    status.name = name
    return status


class DiagnosticTaskVector:
    """A list of tasks."""

    class DiagnosticTaskInternal:
        """A name and a function."""

        def __init__(self, name, fn):
            self.name = name
            self.fn = fn

        def run(self, stat):
            """Call it on a status of that name."""
            stat.name = self.name
            return self.fn(stat)

    def __init__(self):
        self.tasks = []
        self.lock = threading.Lock()

    def addedTaskCallback(self, task):
        """One was added."""

    def add(self, *args):
        """Add a task: `add(task)`, or `add(name, function)`."""
        name, function = args if len(args) == 2 else (args[0].getName(), args[0].run)
        task = self.DiagnosticTaskInternal(name, function)
        with self.lock:
            self.tasks.append(task)
            self.addedTaskCallback(task)

    def removeByName(self, name):
        """Remove the first task of that name; True when there was one."""
        with self.lock:
            found = next((task for task in self.tasks if task.name == name), None)
            if found is not None:
                self.tasks.remove(found)
            return found is not None


class Updater(DiagnosticTaskVector):
    """Runs its tasks every `~diagnostic_period` seconds (1); call `update` more often than that."""

    def __init__(self):
        super().__init__()
        self.publisher = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)
        self.last_time = self.last_time_period_checked = rospy.Time.now()
        self.period = 1
        self.verbose = False
        self.hwid = ""
        self.warn_nohwid_done = False

    def setHardwareID(self, hwid):
        """Name of the device; "none" when there is none."""
        self.hwid = hwid

    def update(self):
        """Run and publish when it is time."""
        self._check_diagnostic_period()
        if rospy.Time.now() >= self.last_time + rospy.Duration(self.period):
            self.force_update()

    def _check_diagnostic_period(self):
        now = rospy.Time.now()
        if now >= self.last_time_period_checked + rospy.Duration(0.25):
            self.period = rospy.get_param_cached("~diagnostic_period", 1)
            self.last_time_period_checked = now

    def force_update(self):
        """Run and publish now."""
        self.last_time = rospy.Time.now()
        found = []
        with self.lock:
            for task in self.tasks:
                status = _status(task.name)
                status.summary(ERROR, "No message was set")
                status.hardware_id = self.hwid
                task.run(status)
                found.append(status)
                if self.verbose and status.level:
                    rospy.logwarn(
                        "Non-zero diagnostic status. Name: '%s', status %i: '%s'"
                        % (status.name, status.level, status.message)
                    )
        if not self.hwid and not self.warn_nohwid_done and not any(status.level for status in found):
            rospy.logwarn(_NO_HARDWARE)
            self.warn_nohwid_done = True
        self.publish(found)

    def broadcast(self, lvl, msg):
        """Publish one level and message for all tasks, without running them."""
        found = [_status(task.name) for task in self.tasks]
        for status in found:
            status.summary(lvl, msg)
        self.publish(found)

    def publish(self, msg):
        """Publish a status or a list of them; the node's name is put before theirs."""
        found = msg if type(msg) is list else [msg]
        for status in found:
            status.name = rospy.get_name()[1:] + ": " + status.name
        message = DiagnosticArray(status=found)
        message.header.stamp = rospy.Time.now()
        self.publisher.publish(message)

    def addedTaskCallback(self, task):
        """Say that it begins."""
        status = _status(task.name)
        status.summary(OK, "Node starting up")
        self.publish(status)


class FrequencyStatusParam:
    """What frequency is right: a dict with "min" (and "max") in Hz, a tolerance (0.1 is 10 %), windows.

    The dict is read at every report: changing its values changes what is right.
    """

    def __init__(self, freq_bound, tolerance=0.1, window_size=5):
        self.freq_bound = freq_bound
        self.tolerance = tolerance
        self.window_size = window_size


class FrequencyStatus(DiagnosticTask):
    """Counts calls of `tick`; warns when they are too rare or too many, an error when there are none."""

    def __init__(self, params, name="FrequencyStatus"):
        super().__init__(name)
        self.params = params
        self.lock = threading.Lock()
        self.clear()

    def clear(self):
        """Begin anew."""
        with self.lock:
            self.count = 0
            self.hist_indx = 0
            self.times = [rospy.Time.now()] * self.params.window_size
            self.seq_nums = [0] * self.params.window_size

    def tick(self):
        """It happened."""
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


class TimeStampStatusParam:
    """How old stamps may be, seconds; negative for the future."""

    def __init__(self, min_acceptable=-1, max_acceptable=5):
        self.max_acceptable = max_acceptable
        self.min_acceptable = min_acceptable


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
        """A stamp, as Time or seconds (a float)."""
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
                self._judge(stat)
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

    def _judge(self, stat):
        """The last thing that is wrong is what is said."""
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
    """Always OK: the node lives."""

    def __init__(self):
        super().__init__("Heartbeat")

    def run(self, stat):
        """Say so."""
        stat.summary(OK, "Alive")
        return stat


class HeaderlessTopicDiagnostic(CompositeDiagnosticTask):
    """A topic's frequency; adds itself to an Updater."""

    def __init__(self, name, diag, freq):
        super().__init__(name + " topic status")
        self.diag = diag
        self.freq = FrequencyStatus(freq)
        self.addTask(self.freq)
        diag.add(self)

    def tick(self):
        """It was published."""
        self.freq.tick()

    def clear_window(self):
        """Forget what was counted."""
        self.freq.clear()


class TopicDiagnostic(HeaderlessTopicDiagnostic):
    """A topic's frequency, and its stamps."""

    def __init__(self, name, diag, freq, stamp):
        super().__init__(name, diag, freq)
        self.stamp = TimeStampStatus(stamp)
        self.addTask(self.stamp)

    def tick(self, stamp):
        """It was published with this stamp."""
        self.stamp.tick(stamp)
        self.freq.tick()


class DiagnosedPublisher(TopicDiagnostic):
    """A Publisher of messages with a header, watched."""

    def __init__(self, pub, diag, freq, stamp):
        super().__init__(pub.name, diag, freq, stamp)
        self.publisher = pub

    def publish(self, message):
        """Note it and publish it."""
        self.tick(message.header.stamp)
        self.publisher.publish(message)
