"""The output of `woosh`: the exit codes that it adds, and its languages."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy
from functools import partial
from typing import TYPE_CHECKING, TextIO

from rosproto import cli
from rosproto.cli import DONE, FAILED, INTERRUPTED, TERMINATED, UNREACHABLE, WRONG_USE, own
from rosproto.sentence import Sentence, say
from woosh_pure.enums import TaskState
from woosh_pure.language import said, translated

if TYPE_CHECKING:
    from woosh_pure.values.state import RobotStatus

REFUSED, NOT_KNOWN = 3, 5
EXIT_CODES = {
    DONE: "done",
    FAILED: "it failed, or the answer is no; one sentence on stderr says why and what to do",
    WRONG_USE: "wrong use; an argument is missing, unknown or out of range; nothing was sent",
    REFUSED: "the chassis is not ready, or refused to move",
    UNREACHABLE: "the chassis cannot be reached, or the connection was lost",
    NOT_KNOWN: "the answer is not known; the chassis has not reported it (`ready`, `faults`)",
    INTERRUPTED: "interrupted by Ctrl-C; a motion of this command was stopped",
    TERMINATED: "ended by SIGTERM, a hang-up or a closed console; a motion of this command was stopped",
}
"""What the exit codes mean."""
READY = {"yes": DONE, "no": REFUSED, "not known": NOT_KNOWN}
"""Exit codes of `woosh ready`, by its answer."""


class Output(cli.Output):
    """The output of a `woosh` command.

    Attributes:
        language: Language of the lines, see `woosh_pure.language`.
    """

    def __init__(self, *, as_json: bool = False, stream: TextIO | None = None, language: str = "en") -> None:
        super().__init__(as_json=as_json, stream=stream, translate=partial(translated, language=language))
        self.language = language


class LogLines(logging.Formatter):
    """Lines of the log on stderr: they, and the sentences in them, are in the language of the command."""

    def __init__(self, language: str) -> None:
        super().__init__()
        self._language = language

    def format(self, record: logging.LogRecord) -> str:
        record = copy(record)
        record.msg = translated(str(record.msg), self._language)
        if isinstance(record.args, tuple):
            record.args = tuple(
                said(each, self._language) if isinstance(each, (Sentence, BaseException)) else each
                for each in record.args
            )
        return super().format(record)


def task_words(status: RobotStatus) -> Sentence:
    """Return the running task, or the last one."""
    if status.task_state is TaskState.UNDEFINED:
        return say("no task")
    return say("task {id} {task}", id=status.task_id, task=status.task_state)


@contextmanager
def full_screen(stream: TextIO) -> Iterator[None]:
    """Use the terminal's alternate screen without a cursor within the block; always restore it."""
    own(stream).write("\x1b[?1049h\x1b[?25l\x1b[2J")
    stream.flush()
    try:
        yield
    finally:
        own(stream).write("\x1b[?25h\x1b[?1049l")
        stream.flush()
