"""The errors of a transform lookup."""

from __future__ import annotations

from rosproto.errors import RosError


class TransformError(RosError, LookupError):
    """There is no such transform.

    Attributes:
        target: Frame requested.
        source: Frame of the data.
    """

    def __init__(self, message: str, *, target: str = "", source: str = "") -> None:
        super().__init__(f"{target} <- {source}: {message}" if target else message)
        self.target = target
        self.source = source


class UnknownFrame(TransformError):
    """The frame has not been published.

    Attributes:
        frame: The frame.
    """

    def __init__(self, message: str, *, frame: str, target: str = "", source: str = "") -> None:
        super().__init__(message, target=target, source=source)
        self.frame = frame


class NotConnected(TransformError):
    """Both frames are known, but belong to separate trees.

    Attributes:
        target_root, source_root: The root of each tree.
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
    """The requested time is outside the known range.

    Attributes:
        parent, child: The edge of the tree that is unknown at that time.
        requested: Requested time, seconds.
        earliest, latest: Known range of that edge, seconds.
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
