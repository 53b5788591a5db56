"""A status to be filled by tasks."""

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
        """Set level and message: from `(level, message)`, or from another status."""
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
