"""The topics that one client publishes."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError
from rosproto.gateway.foxglove.publish import Advert, NotOpen, Refused
from rosproto.gateway.foxglove.serial_executor import SerialExecutor

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.shared import Shared

__all__ = ["AdvertisedTopics"]


class AdvertisedTopics:
    """Opens and feeds them in the order in which the client asks. No method waits but `close`.

    Args:
        shared: Publishes at the robot.
        client: Stands for the client where zeros follow what it drove.
        tell: Sends the client a status text.
        closed: Whether the session has ended.

    Attributes:
        published: Messages so far.
    """

    def __init__(
        self, shared: Shared, client: Hashable, tell: Callable[[str], None], closed: Callable[[], bool]
    ) -> None:
        self.published = 0
        self._shared = shared
        self._client = client
        self._tell = tell
        self._closed = closed
        self._executor = SerialExecutor(shared.pool)
        self._adverts: dict[int, Advert] = {}
        self._not_open: dict[int, str] = {}

    def advertise(self, channel: Any) -> None:
        """The client begins to publish on a channel."""
        self._executor.submit(lambda: self._advertise(channel))

    def _advertise(self, channel: Any) -> None:
        if self._closed():
            return
        try:
            most = self._shared.limits.advertised_per_client
            if len(self._adverts) + len(self._not_open) >= most:
                raise Refused(f"{most} topics are published: no more for this client")
            self._leave(channel.id)
            self._adverts[channel.id] = self._shared.client_topics.advertise(self._client, channel)
        except NotOpen as problem:
            self._not_open[channel.id] = str(problem)
        except (Refused, RosError) as problem:
            self._shared.refusals += 1
            self._tell(str(problem))

    def publish(self, channel: int, data: bytes) -> None:
        """The client publishes a message; the oldest waiting one goes when too many wait."""
        self._executor.submit(lambda: self._publish(channel, data), droppable=True)

    def _publish(self, channel: int, data: bytes) -> None:
        advert = self._adverts.get(channel)
        if self._closed():
            return
        if advert is None:
            refusal = self._not_open.get(channel)  # other refusals were told when it was advertised
            if refusal is not None:
                self._shared.refusals += 1
                self._tell(refusal)
            return
        try:
            self._shared.client_topics.publish(advert, data)
            self.published += 1
        except (Refused, RosError) as problem:
            self._tell(str(problem))

    def unadvertise(self, channel: int) -> None:
        """The client no longer publishes on a channel."""
        self._executor.submit(lambda: self._leave(channel))

    def _leave(self, channel: int) -> None:
        self._not_open.pop(channel, None)
        advert = self._adverts.pop(channel, None)
        if advert is not None:
            advert.close()

    def stop(self) -> None:
        """Begin nothing more."""
        self._executor.close()

    def close(self) -> None:
        """Publish nothing any more."""
        self.stop()
        for channel in tuple(self._adverts):
            self._leave(channel)
