"""Why a call of /rosapi has no answer."""

from __future__ import annotations

from rosproto.errors import RosError

__all__ = ["RosapiError"]


class RosapiError(RosError):
    """A call of /rosapi that is refused or cannot be answered; its text is a sentence for the client."""
