"""Runs the web application: uvicorn in a thread, as a `with` block."""

from __future__ import annotations

import asyncio
import errno
import socket
import ssl
import threading
import time
from collections.abc import Coroutine
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from rosproto.admission import ConnectionSlots
from rosproto.aio import BudgetedProtocol, ReadBudget
from rosproto.errors import ConnectionLost
from rosproto.logs import PeerLog, get_logger
from rosproto.sentence import say
from rosproto.transport import AT_ONCE, Listener, make_uri

if TYPE_CHECKING:
    from starlette.applications import Starlette


PONG_SECONDS = 4.0
"""A WebSocket that does not answer a ping within this time is closed. The time is longer than a short outage
of a radio link, and shorter than the six seconds after which the page connects again."""

_logger = get_logger("woosh_pure.web")
_peer_log = PeerLog("woosh_pure.web")
START_SECONDS, LEAVE_SECONDS, END_SECONDS = 10.0, 0.6, 3.0
"""Time for the server to start; for clients to receive the rest and disconnect; and for the server to end."""


class WebServer:
    """Serves an application made by `woosh_pure.web.app` while a `with` block lasts. Leaving the block ends
    driving by velocity first.

    Args:
        app: The application.
        bind: Address to listen on. If it is not a loopback address, the application must have a token.
        port: TCP port; 0 takes a free one.
        tls_cert: Certificate file (PEM); if given, the server speaks https.
        tls_key: Key file, if the key is not in the certificate file.

    Raises:
        ValueError: Other computers could reach the server, and there is no token; or the TLS files hold no
            certificate with its key.
        OSError: Listening on the address failed, or a TLS file cannot be read.
    """

    def __init__(
        self,
        app: Starlette,
        *,
        bind: str = "127.0.0.1",
        port: int = 8080,
        tls_cert: str | Path | None = None,
        tls_key: str | Path | None = None,
    ) -> None:
        import uvicorn

        ws: Any = "none"  # without the library, as for `woosh mcp --http`; `web.app` has checked for it
        with suppress(ImportError):
            from woosh_pure.web.websocket_protocol import LimitedWebSocketProtocol

            ws = LimitedWebSocketProtocol

        self.app = app
        app.state.context.access.require_token_at(bind)
        if tls_key and not tls_cert:
            raise ValueError("a TLS key without a certificate; give both")
        if tls_cert:
            _check_tls(tls_cert, tls_key)
        self._slots = app.state.context.slots
        self._socket = listen_at(bind, port, self._slots)
        self.port = int(self._socket.getsockname()[1])
        self.scheme = "https" if tls_cert else "http"
        shown = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(bind, bind.strip("[]"))
        self.url = make_uri(shown, self.port, self.scheme)
        config = uvicorn.Config(
            app,
            http=_budgeted(ReadBudget(_log_flood, share=0.25)),
            ws=ws,
            lifespan="off",
            log_level="warning",
            access_log=False,
            backlog=AT_ONCE,
            server_header=False,
            proxy_headers=False,
            timeout_keep_alive=5,
            timeout_graceful_shutdown=1,
            ws_max_size=64 * 1024,
            ws_ping_interval=2.0,
            ws_ping_timeout=PONG_SECONDS,
            ws_per_message_deflate=False,
            ssl_certfile=tls_cert or None,
            ssl_keyfile=tls_key or None,
        )
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._run, name="woosh:web server", daemon=True)
        self._error: BaseException | None = None
        self.loop: asyncio.AbstractEventLoop | None = None

    def _run(self) -> None:
        try:
            _run_alone(self._serve())
        except BaseException as error:
            self._error = error
            if not isinstance(error, SystemExit):
                _logger.exception("! the server has failed")

    async def _serve(self) -> None:
        self.loop = asyncio.get_running_loop()
        tidying = asyncio.ensure_future(self._tidy())
        try:
            await self._server.serve(sockets=[self._socket])
        finally:
            tidying.cancel()

    async def _tidy(self) -> None:
        while not self._server.should_exit:
            await asyncio.sleep(0.1)
            self._slots.drop_silent(time.monotonic())
        await asyncio.sleep(LEAVE_SECONDS)
        self._slots.drop_all()

    def __enter__(self) -> WebServer:
        self._thread.start()
        until = time.monotonic() + START_SECONDS
        while not self._server.started:
            if not self._thread.is_alive() or time.monotonic() > until:
                self.close()
                raise OSError(say("the server did not start: {error}", error=self._error or say("no answer")))
            time.sleep(0.01)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def running(self) -> bool:
        """Whether the server runs."""
        return self._thread.is_alive()

    def close(self) -> None:
        """End driving, then the server, in a bounded time. Idempotent."""
        self.app.state.context.close("the server is shutting down")
        self._server.should_exit = True
        if self._thread.is_alive():
            self._thread.join(END_SECONDS)
        if self._thread.is_alive():
            self._server.force_exit = True
            self._thread.join(END_SECONDS)
        self._socket.close()


def listen_at(bind: str, port: int, slots: ConnectionSlots) -> Listener:
    """Listen for the server.

    Raises:
        OSError: Listening on this address failed; the message says what to do.
    """
    try:
        return Listener(bind, port, slots)
    except ConnectionLost as error:
        why = error.__cause__
        foreign = isinstance(why, socket.gaierror) or getattr(why, "errno", None) == errno.EADDRNOTAVAIL
        other = "give another --port (--page-port of `woosh run` and `woosh sim`)"
        advice = "--bind takes an address of this computer" if foreign else other
        raise OSError(
            getattr(why, "errno", None) or errno.EINVAL,
            say(
                "cannot listen at {bind} port {port}: {error}; {advice}",
                bind=bind,
                port=port,
                error=getattr(why, "strerror", None) or why or error,
                advice=say(advice),
            ),
        ) from error


def _budgeted(budget: ReadBudget) -> type[asyncio.Protocol]:
    """uvicorn's protocol for HTTP within a budget; it gives its transport to the WebSocket protocol."""
    from uvicorn.protocols.http.h11_impl import H11Protocol

    class Http(BudgetedProtocol):
        def __init__(self, **given: Any) -> None:
            super().__init__(budget, H11Protocol(**given))

    return Http


def _log_flood(transport: asyncio.BaseTransport) -> None:
    host, port, *_ = transport.get_extra_info("peername") or ("?", 0)
    _peer_log.warning(
        "flood", "! %s:%s disconnected: it keeps sending data that is not a message", host, port
    )


def _check_tls(cert: str | Path, key: str | Path | None) -> None:
    """Check the files before the server's thread starts."""
    for file in (cert, key):
        if file is not None:
            Path(file).open("rb").close()
    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(cert, key, password="")
    except ssl.SSLError as error:
        wrong = (
            "{cert} and {key} are not a PEM certificate and its unencrypted key ({error})"
            if key
            else "{cert} is not a PEM certificate with its unencrypted key ({error})"
        )
        raise ValueError(say(wrong, cert=cert, key=key, error=error.reason or say("not PEM"))) from error


def _run_alone(main: Coroutine[object, object, None]) -> None:
    """Run in asyncio's selector event loop, because the proactor loop of Windows and uvloop do not call
    `Listener.accept`.
    """
    loop = asyncio.SelectorEventLoop()
    try:
        asyncio.set_event_loop(loop)
        loop.run_until_complete(main)
    finally:
        try:
            left = asyncio.all_tasks(loop)
            for task in left:
                task.cancel()
            loop.run_until_complete(asyncio.gather(*left, return_exceptions=True))
            loop.run_until_complete(loop.shutdown_asyncgens())
        finally:
            asyncio.set_event_loop(None)
            loop.close()
