"""Diagnostics of a topic: of its frequency, and of the stamps of its messages."""

from ._diagnostic_updater import CompositeDiagnosticTask
from ._update_functions import FrequencyStatus, TimeStampStatus


class HeaderlessTopicDiagnostic(CompositeDiagnosticTask):
    """A topic's frequency; adds itself to an Updater."""

    def __init__(self, name, diag, freq):
        super().__init__(name + " topic status")
        self.diag = diag
        self.freq = FrequencyStatus(freq)
        self.addTask(self.freq)
        diag.add(self)

    def tick(self):
        """Note that a message was published."""
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
        """Note that a message with this stamp was published."""
        self.stamp.tick(stamp)
        self.freq.tick()


class DiagnosedPublisher(TopicDiagnostic):
    """A Publisher of messages with a header, watched."""

    def __init__(self, pub, diag, freq, stamp):
        super().__init__(pub.name, diag, freq, stamp)
        self.publisher = pub

    def publish(self, message):
        """Publish a message and note it."""
        self.tick(message.header.stamp)
        self.publisher.publish(message)
