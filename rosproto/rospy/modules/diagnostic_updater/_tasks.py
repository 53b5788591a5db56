"""A status that is easy to fill, and the tasks that fill it."""

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

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
