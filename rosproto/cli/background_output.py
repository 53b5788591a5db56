"""Writes standard output and error in the background, so that a slow or missing reader delays nothing.

A write to a full pipe, or to a terminal stopped by Ctrl-S, blocks for ever. It would block a stop, a deadline
or a logging thread. So one thread per stream writes, and the command only queues its text:

- stdout holds documents. With `MAX_UNREAD_PIECES` unread, the command waits; Ctrl-C and signals end the wait.
  After `never_wait_for_stdout` it drops further pieces instead: a command that moves the robot must not wait.
- stderr holds messages and logs. It never waits: with `MAX_UNREAD_PIECES` unread, further ones are dropped.

The queue and the locks are C code: an exception in a signal handler leaves none of them locked, and a handler
may use them again.
"""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from queue import SimpleQueue
from typing import Any, TextIO

from rosproto.cli.console import OutputError, TerminalGone
from rosproto.cli.signals import Terminated

MAX_UNREAD_PIECES = 500
"""Pieces of text that may wait for their reader."""
_LARGE = 65536  # bytes; `write` waits for a piece of this size
_BATCH = 64  # pieces per write
_MOMENT = 0.1  # s that `flush` waits for a slow reader
_AT_THE_END = 1.0  # s that a command's end waits for stderr, and for stdout after `never_wait_for_stdout`
_STEP = 0.5  # s; Windows delivers no Ctrl-C to a thread in an endless wait


class BackgroundOutput:
    """A text stream with writes in a thread; other attributes are the stream's.

    Args:
        stream: Standard output or error.
        waits: Whether `write` blocks while `MAX_UNREAD_PIECES` pieces are unread.
        after: A stream to write first when both are the same terminal.

    Attributes:
        waits: See above.
        dropped: Number of pieces dropped.
    """

    def __init__(
        self, stream: io.TextIOWrapper, *, waits: bool, after: BackgroundOutput | None = None
    ) -> None:
        self.waits = waits
        self.dropped = 0
        self._stream = stream
        self._is_terminal = stream.isatty()
        # The unbuffered file has no lock. A blocked write would hold a buffer's lock for ever, and the
        # interpreter acquires it at exit.
        self._file: Any = getattr(stream.buffer, "raw", stream.buffer)
        self._encode = codecs.getincrementalencoder(stream.encoding)(stream.errors or "strict").encode
        self._after = after
        self._pieces: SimpleQueue[bytes | threading.Lock] = SimpleQueue()  # a lock is released when reached
        self._error: OSError | None = None
        self._unread = False
        threading.Thread(target=self._run, name="rosproto:output", daemon=True).start()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Queue a text.

        Raises:
            OSError: The reader has gone, or the disk is full; raised by the first call after the failure.
        """
        self._fail()
        if self._after is not None:
            self._after.settle()
        data = self._encode(text.replace("\n", os.linesep))
        if self._pieces.qsize() >= MAX_UNREAD_PIECES:
            if not self.waits:
                self.dropped += 1
                return len(text)
            self.written(None)
        self._pieces.put(data)
        if self.waits and len(data) > _LARGE:
            self.written(None)
        return len(text)

    def writelines(self, lines: list[str]) -> None:
        """Queue each line."""
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        """Wait up to `_MOMENT` for the queued text, unless the reader is already slower than that.

        Only the main thread waits: other threads only log.
        """
        if not sys.is_finalizing():
            self.settle()
            self._fail()

    def settle(self) -> None:
        """Like `flush`, but ignore errors. At the end of the interpreter the thread no longer runs."""
        if self._unread or sys.is_finalizing():
            return
        if threading.current_thread() is threading.main_thread():
            self._unread = not self.written(_MOMENT)

    def written(self, timeout: float | None) -> bool:
        """Wait until all queued text is written; return False on timeout."""
        end = None if timeout is None else time.monotonic() + timeout
        here = threading.Lock()
        here.acquire()
        self._pieces.put(here)
        while not here.acquire(
            timeout=_STEP if end is None else max(0.0, min(_STEP, end - time.monotonic()))
        ):
            if end is not None and time.monotonic() >= end:
                return False
            if end is None and not self.waits:
                end = time.monotonic() + _AT_THE_END  # `never_wait_for_stdout` was called meanwhile
        return True

    def _fail(self) -> None:
        if self._error is not None:
            raise OutputError.of(type(self._error)(*self._error.args))

    def _run(self) -> None:
        while True:
            batch = [self._pieces.get()]
            while len(batch) < _BATCH and not self._pieces.empty():
                batch.append(self._pieces.get())
            self._put(b"".join(piece for piece in batch if isinstance(piece, bytes)))
            self._unread = False
            for piece in batch:
                if not isinstance(piece, bytes):
                    piece.release()

    def _put(self, data: bytes) -> None:
        rest = memoryview(data)
        while rest and self._error is None:
            try:
                count = self._file.write(rest)
            except OSError as error:
                gone = error.errno == errno.EIO and self._is_terminal
                self._error = TerminalGone(*error.args) if gone else error
            except ValueError:  # closed by the program
                self._error = OSError("the stream is closed")
            else:
                if count is None:  # the file is non-blocking
                    time.sleep(0.01)
                rest = rest[count or 0 :]


@contextmanager
def in_background() -> Iterator[None]:
    """Replace stdout and stderr by `BackgroundOutput`, and write what is queued when the block ends.

    They stay replaced: the interpreter itself may print at its end, as of an error in a destructor, and would
    wait for the reader for ever. Its last messages go to `sys.__stderr__`.
    """
    ours: tuple[Any, Any]
    try:
        out = _of(sys.stdout, waits=True)
        ours = out, _of(sys.stderr, waits=False, after=out if isinstance(out, BackgroundOutput) else None)
    except RuntimeError:  # no thread can be started: write directly
        ours = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = ours
    try:
        yield
    finally:
        try:
            for stream in ours:
                if isinstance(stream, BackgroundOutput):
                    stream.written(None if stream.waits else _AT_THE_END)
        except (KeyboardInterrupt, Terminated):
            pass  # discard the rest
        never_wait_for_stdout()
        sys.__stdout__, sys.__stderr__ = ours  # type: ignore[misc]


def _of(stream: TextIO, *, waits: bool, after: BackgroundOutput | None = None) -> Any:
    if not isinstance(stream, io.TextIOWrapper):
        return stream
    stream.flush()
    return BackgroundOutput(stream, waits=waits, after=after)


def never_wait_for_stdout() -> None:
    """Let stdout drop unread text from now on, so that a motion never waits for a reader."""
    stream = _background(sys.stdout)
    if stream is not None:
        stream.waits = False


def everything_is_written() -> None:
    """Wait until stdout is written: without a limit, or at most `_AT_THE_END` after `never_wait_for_stdout`.

    Raises:
        OSError: It cannot be written.
    """
    stream = _background(sys.stdout)
    if stream is not None:
        stream.written(None if stream.waits else _AT_THE_END)
    if sys.stdout is not None:
        sys.stdout.flush()  # a full disk or a closed pipe shows here, not at exit


def _background(stream: object) -> BackgroundOutput | None:
    stream = getattr(stream, "unguarded", stream)
    return stream if isinstance(stream, BackgroundOutput) else None
