"""The outbox of one subscriber: what it has not taken yet, and what is given up when that is too much.

No I/O here: `SubscriberLink` sends what `take` hands out and says with `sent` how far it came.

Drop policy: at most `size` whole messages wait; a new one pushes the oldest out. A message of which some
bytes are on the wire already is always finished, else the stream would be out of step.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from rosproto.node.outgoing.frames import LargeFrame, remaining

BATCH = 64 << 10  # bytes joined for one send: more gains nothing (measured)

Frame = bytes | LargeFrame
NONE: deque[Frame] = deque()
"""What an outbox holds that was never used, as most are: a deque of its own would be half of an idle link."""


class Outbox:
    """Bounded queue of frames, oldest dropped.

    Attributes:
        size: Most whole frames that wait.
        dropped: Frames given up so far.
    """

    __slots__ = ("_begun", "_frames", "dropped", "size")

    def __init__(self, size: int) -> None:
        self.size = size
        self.dropped = 0
        self._frames = NONE
        self._begun: list[memoryview] = []

    def put(self, frame: Frame) -> None:
        """Add a frame; the oldest goes when there are too many."""
        frames = self._frames
        if frames is NONE:
            frames = self._frames = deque()
        frames.append(frame)
        if len(frames) > self.size:
            frames.popleft()
            self.dropped += 1

    def begin(self, rest: Iterable[memoryview]) -> None:
        """Keep the rest of a frame whose start is on the wire; it goes before everything else."""
        assert not self._begun, "one frame is begun at a time"
        self._begun = [view for view in rest if view.nbytes]

    def take(self) -> list[bytes | memoryview]:
        """What to send next: the frame begun, or some whole frames (about `BATCH` bytes); [] when empty."""
        if self._begun:
            return list(self._begun)
        batch: list[bytes | memoryview] = []
        size = 0
        for frame in self._frames:
            if isinstance(frame, LargeFrame):
                return batch or list(frame.views)
            size += len(frame)
            if batch and size > BATCH:
                break
            batch.append(frame)
        return batch

    def sent(self, count: int) -> int:
        """Note that the first `count` bytes of the last `take` are on the wire.

        Returns:
            How many frames were completed.
        """
        if self._begun:
            self._begun = remaining(self._begun, count)
            return 0 if self._begun else 1
        done = 0
        while count:
            frame = self._frames.popleft()
            if len(frame) > count:
                views = frame.views if isinstance(frame, LargeFrame) else [memoryview(frame)]
                self._begun = remaining(views, count)
                break
            count -= len(frame)
            done += 1
        return done

    def pop(self) -> bytes | None:
        """The oldest frame, for who sends it in a way of its own; None when empty."""
        if not self._frames:
            return None
        frame = self._frames.popleft()
        return frame.owned() if isinstance(frame, LargeFrame) else frame

    def clear(self) -> int:
        """Forget everything (the link is dead: nothing is replayed later); how many frames that were."""
        lost = len(self._frames) + bool(self._begun)
        self._frames = NONE
        self._begun = []
        return lost

    def __len__(self) -> int:
        return len(self._frames) + bool(self._begun)

    def __bool__(self) -> bool:
        return bool(self._frames) or bool(self._begun)
