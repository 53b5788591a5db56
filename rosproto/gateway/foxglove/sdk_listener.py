"""The object whose methods the SDK calls for one client."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.session import Session

__all__ = ["SdkListener"]


class SdkListener:
    """Passes the SDK's calls to the session, in the SDK's threads; only those about parameters wait."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def on_subscribe(self, client: Any, channel: Any) -> None:
        self._session.subscribed(client.id, channel.id)

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        self._session.unsubscribed(client.id, channel.id)

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        self._session.advertised(client.id, channel)

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        self._session.unadvertised(client.id, client_channel_id)

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        self._session.message(client.id, client_channel_id, data)

    def on_get_parameters(
        self, client: Any, param_names: list[str], request_id: str | None = None
    ) -> list[Any]:
        return self._session.get_parameters(client.id, param_names)

    def on_set_parameters(
        self, client: Any, parameters: list[Any], request_id: str | None = None
    ) -> list[Any]:
        return self._session.set_parameters(client.id, parameters)

    def on_parameters_subscribe(self, param_names: list[str]) -> None:
        self._session.follow_parameters(param_names)

    def on_parameters_unsubscribe(self, param_names: list[str]) -> None:
        self._session.leave_parameters(param_names)

    def on_connection_graph_subscribe(self) -> None:
        self._session.want_graph(True)

    def on_connection_graph_unsubscribe(self) -> None:
        self._session.want_graph(False)
