"""Writes standard output and error in the background, so that a slow or missing reader delays nothing.

A pipe that nobody reads is full after some KiB, and so is a terminal that was stopped by Ctrl-S. Who writes
there waits for ever: a command that says "stopping" before it stops, a deadline behind a line of progress, a
thread that logs. So one thread for each stream writes, and the command hands its text over:

- stdout is for documents. When `MOST` pieces wait for their reader, the command waits, too; Ctrl-C and
  signals interrupt it. After `hurry` it does not: a command that moves something drops what nobody reads.
- stderr is for people and logs. It never waits: with `MOST` pieces unread, further ones are dropped.

Nothing here has a lock of Python's that an exception of a signal handler could leave behind: the queue and
the locks that are waited for are C code, and may be used again by a handler that interrupts them.
"""

from __future__ import annotations

import codecs
import io
import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from queue import SimpleQueue
from typing import Any

from .console import OutputError
from .signals import Terminated

MOST = 500
"""Pieces of text that may wait for their reader."""
_LARGE = 65536  # bytes; so long a piece is waited for by itself
_BATCH = 64  # pieces that are written at once
_MOMENT = 0.1  # s that `flush` waits for a reader who may just be slow
_AT_THE_END = 1.0  # s that the end of a command waits for somebody to read stderr, and what was hurried
_STEP = 0.5  # s; Windows delivers no Ctrl-C to a thread in an endless wait


class BackgroundOutput:
    """A text stream that a thread writes; everything else of it is the stream's own.

    Args:
        stream: Of the process.
        waits: Whether `write` waits for a reader when `MOST` pieces are unread.
        after: A stream whose lines come first when both are one terminal.

    Attributes:
        waits: See above.
        dropped: Pieces that nobody read in time.
    """

    def __init__(
        self, stream: io.TextIOWrapper, *, waits: bool, after: BackgroundOutput | None = None
    ) -> None:
        self.waits = waits
        self.dropped = 0
        self._stream = stream
        # The unbuffered file has no lock: a buffer's would be held for ever by a write that nobody reads, and
        # asked for once more when the interpreter ends.
        self._file: Any = getattr(stream.buffer, "raw", stream.buffer)
        self._encode = codecs.getincrementalencoder(stream.encoding)(stream.errors or "strict").encode
        self._after = after
        self._pieces: SimpleQueue[bytes | threading.Lock] = SimpleQueue()  # a lock: tell when you are here
        self._error: OSError | None = None
        self._unread = False
        threading.Thread(target=self._run, name="rosproto:output", daemon=True).start()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Hand a text over.

        Raises:
            OSError: Nobody reads it any more, or the disk is full; as soon as that is known.
        """
        self._fail()
        if self._after is not None:
            self._after.settle()
        data = self._encode(text.replace("\n", os.linesep))
        if self._pieces.qsize() >= MOST:
            if not self.waits:
                self.dropped += 1
                return len(text)
            self.written(None)
        self._pieces.put(data)
        if self.waits and len(data) > _LARGE:
            self.written(None)
        return len(text)

    def writelines(self, lines: list[str]) -> None:
        """Hand each of them over."""
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        """Wait a moment for what was handed over, unless nobody has read for longer than that.

        Only the main thread waits: others serve somebody, and merely log.
        """
        self.settle()
        self._fail()

    def settle(self) -> None:
        """As `flush`, whatever came of it."""
        if not self._unread and threading.current_thread() is threading.main_thread():
            self._unread = not self.written(_MOMENT)

    def written(self, timeout: float | None) -> bool:
        """Wait until everything handed over is written; False when it was not in time."""
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
                end = time.monotonic() + _AT_THE_END  # hurried meanwhile
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
                self._error = error
            except ValueError:  # closed by the program
                self._error = OSError("the stream is closed")
            else:
                if count is None:  # somebody has made it non-blocking
                    time.sleep(0.01)
                rest = rest[count or 0 :]


@contextmanager
def in_background() -> Iterator[None]:
    """Within the block stdout and stderr of this process are `BackgroundOutput`."""
    before: Any = sys.stdout, sys.stderr
    try:
        out = _of(sys.stdout, waits=True)
        ours: Any = (
            out,
            _of(sys.stderr, waits=False, after=out if isinstance(out, BackgroundOutput) else None),
        )
    except RuntimeError:  # no thread can be started: as without this module
        ours = before
    sys.stdout, sys.stderr = ours
    try:
        yield
    finally:
        try:
            for stream in ours:
                if isinstance(stream, BackgroundOutput):
                    stream.written(None if stream.waits else _AT_THE_END)
        except (KeyboardInterrupt, Terminated):
            pass  # nobody is to read the rest
        if (sys.stdout, sys.stderr) == ours:
            sys.stdout, sys.stderr = before


def _of(stream: Any, *, waits: bool, after: BackgroundOutput | None = None) -> Any:
    if not isinstance(stream, io.TextIOWrapper):
        return stream
    stream.flush()
    return BackgroundOutput(stream, waits=waits, after=after)


def hurry() -> None:
    """From now on stdout waits for nobody: what this command moves must not wait for who reads about it."""
    stream = _background(sys.stdout)
    if stream is not None:
        stream.waits = False


def everything_is_written() -> None:
    """Wait until somebody has read what stdout was given, as long as that takes; a hurried one for a second.

    Raises:
        OSError: It cannot be written.
    """
    stream = _background(sys.stdout)
    if stream is not None:
        stream.written(None if stream.waits else _AT_THE_END)
    if sys.stdout is not None:
        sys.stdout.flush()  # a full disk or a closed pipe shows here, not at exit


def _background(stream: Any) -> BackgroundOutput | None:
    stream = getattr(stream, "unguarded", stream)
    return stream if isinstance(stream, BackgroundOutput) else None
