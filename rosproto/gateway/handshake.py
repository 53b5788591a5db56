"""`HandshakeRules`: checks the HTTP request of a WebSocket handshake, and requests by POST. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from rosproto.admission import AdmissionPolicy, AdmissionRefusal, Header, basic_password, bearer_token
from rosproto.protocol.http import Request
from rosproto.sentence import say


class HandshakeRules(AdmissionPolicy):
    """The rules for connecting to one gateway: those of every server, and the subprotocol.

    Args:
        bound: The address that the gateway listens on. A name is one of the gateway's names.
        origins: Origins of pages that may connect; see `AdmissionPolicy`.
        token: The secret that a client must send, as `?token=T`, `Authorization: Bearer T` or the password of
            Basic; None for none.
        subprotocols: A client must offer one of these, the best first, unless there are none;
            `ClientChannel.subprotocol` is the agreed one.
        hosts: Further names of the gateway.

    Raises:
        ValueError: Others can reach the address, and there is no token; or see `AdmissionPolicy`.
    """

    def __init__(
        self,
        bound: str,
        origins: Sequence[str] = (),
        token: str | None = None,
        subprotocols: Sequence[str] = (),
        hosts: Sequence[str] = (),
    ) -> None:
        super().__init__(token, origins, (*hosts, bound))
        self.require_token_at(bound)
        self.bound, self.subprotocols = bound, subprotocols

    def check(
        self, path: str, header: Header, address: str, now: float, *, secure: bool = False
    ) -> AdmissionRefusal | None:
        """Return why a request is refused, or None.

        Args:
            path: Path and query.
            header: Returns all values of a header.
            address: IP address of the client.
            now: The monotonic time.
            secure: Whether the connection is encrypted.
        """
        refusal = self.check_headers(header, "wss" if secure else "ws", changes=True)
        refusal = refusal or self.check_token(_token(path, header("authorization")), address, now)
        if refusal is not None:
            return refusal
        offered = {name.strip() for line in header("sec-websocket-protocol") for name in line.split(",")}
        if self.subprotocols and offered.isdisjoint(self.subprotocols):
            text = say("the client supports none of the protocols {names}", names=list(self.subprotocols))
            return AdmissionRefusal(HTTPStatus.BAD_REQUEST, "protocol", text)
        return None

    def check_post(
        self, request: Request, address: str, now: float, *, secure: bool = False
    ) -> AdmissionRefusal | None:
        """As `check`, for a request without a WebSocket."""
        headers = request.headers
        if request.method != "POST":
            text = say("this server answers POST and WebSockets, and not {method:.20}", method=request.method)
            return AdmissionRefusal(HTTPStatus.METHOD_NOT_ALLOWED, "method", text)
        # A page may send a few other types to any server, which is not asked before.
        kind = headers.get("content-type", "").partition(";")[0].strip().lower()
        if "origin" in headers and kind != "application/json":
            text = say("a page must send its request as application/json")
            return AdmissionRefusal(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "content type", text)
        header: Header = lambda name: [headers[name]] if name in headers else []  # noqa: E731
        return self.check(request.target, header, address, now, secure=secure)


def _token(path: str, authorizations: Sequence[str]) -> str | None:
    """The token in the request; None if it has none, or several."""
    for given in (bearer_token, basic_password):
        if (token := given(authorizations)) is not None:
            return token
    try:
        values = parse_qs(urlsplit(path).query, max_num_fields=100).get("token", [])
    except ValueError:
        return None
    return values[0] if len(values) == 1 else None
