"""Why a transform cannot be had."""

from __future__ import annotations

from rosproto.errors import RosError


class TransformError(RosError, LookupError):
    """A transform cannot be had.

    Attributes:
        target: Frame asked for.
        source: Frame of the data.
    """

    def __init__(self, message: str, *, target: str = "", source: str = "") -> None:
        super().__init__(f"{target} <- {source}: {message}" if target else message)
        self.target = target
        self.source = source


class UnknownFrame(TransformError):
    """Nobody has published this frame.

    Attributes:
        frame: The frame.
    """

    def __init__(self, message: str, *, frame: str, target: str = "", source: str = "") -> None:
        super().__init__(message, target=target, source=source)
        self.frame = frame


class NotConnected(TransformError):
    """Both frames are known, but they hang in two separate trees.

    Attributes:
        target_root, source_root: The topmost frame above each of them.
    """

    def __init__(
        self,
        message: str,
        *,
        target: str = "",
        source: str = "",
        target_root: str = "",
        source_root: str = "",
    ) -> None:
        super().__init__(message, target=target, source=source)
        self.target_root = target_root
        self.source_root = source_root


class ExtrapolationError(TransformError):
    """The time asked for lies outside what is known.

    Attributes:
        parent, child: The edge of the tree that is not known at that time.
        requested: Time asked for, seconds.
        earliest, latest: What is known of that edge, seconds.
    """

    def __init__(
        self,
        message: str,
        *,
        target: str = "",
        source: str = "",
        parent: str = "",
        child: str = "",
        requested: float = 0.0,
        earliest: float = 0.0,
        latest: float = 0.0,
    ) -> None:
        super().__init__(message, target=target, source=source)
        self.parent = parent
        self.child = child
        self.requested = requested
        self.earliest = earliest
        self.latest = latest
