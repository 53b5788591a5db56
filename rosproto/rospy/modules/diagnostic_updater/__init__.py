"""diagnostic_updater: what a node says of its health on /diagnostics (wiki.ros.org/diagnostic_updater)."""

from ._tasks import (
    ERROR,
    OK,
    WARN,
    CompositeDiagnosticTask,
    DiagnosticStatus,
    DiagnosticStatusWrapper,
    DiagnosticTask,
    FunctionDiagnosticTask,
    KeyValue,
)
from ._topics import DiagnosedPublisher, HeaderlessTopicDiagnostic, TopicDiagnostic
from ._updater import DiagnosticArray, DiagnosticTaskVector, Updater
from ._watchers import (
    FrequencyStatus,
    FrequencyStatusParam,
    Heartbeat,
    TimeStampStatus,
    TimeStampStatusParam,
)

__all__ = [
    "ERROR",
    "OK",
    "WARN",
    "CompositeDiagnosticTask",
    "DiagnosedPublisher",
    "DiagnosticArray",
    "DiagnosticStatus",
    "DiagnosticStatusWrapper",
    "DiagnosticTask",
    "DiagnosticTaskVector",
    "FrequencyStatus",
    "FrequencyStatusParam",
    "FunctionDiagnosticTask",
    "HeaderlessTopicDiagnostic",
    "Heartbeat",
    "KeyValue",
    "TimeStampStatus",
    "TimeStampStatusParam",
    "TopicDiagnostic",
    "Updater",
]
