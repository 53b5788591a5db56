"""The middleware that checks every request before its body is read (Host, Origin, token, size), and adds the
security headers to every answer.
"""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import Iterable, Mapping

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rosproto.admission import AdmissionRefusal, Key, bearer_token, require_page_origin
from woosh_pure.web.access import AccessRules, cookie_name, cookies
from woosh_pure.web.context import WebContext
from woosh_pure.web.http_errors import MEDIA_TYPE, REFUSAL_KINDS, Problem, worded

MAX_BODY, BODY_SECONDS = 64 * 1024, 10.0
CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
    "manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_HEADERS = {
    "content-security-policy": CONTENT_POLICY,
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
}
_HEADERS_OF = {
    401: {"www-authenticate": 'Bearer realm="woosh"'},
    413: {"connection": "close"},
    429: {"retry-after": "60"},
}
_OPEN_TO_ALL = ("/api/v1/access", "/api/v1/login")
_SAFE = ("GET", "HEAD", "OPTIONS")


def problem_of_refusal(refusal: AdmissionRefusal | None) -> Problem | None:
    """Convert the refusal of a request."""
    if refusal is None:
        return None
    return Problem(int(refusal.status), refusal.text, REFUSAL_KINDS[refusal.reason])


def login_place(scope: Scope, headers: Headers) -> tuple[str, str]:
    """Return the name of the log-in cookie, and the place for which it is valid, which is this port."""
    name = cookie_name(headers.get("host", ""), scope.get("scheme", "http"))
    return name, f"{name} {(scope.get('server') or ('', 0))[1]}"


def check_access(access: AccessRules, scope: Scope, headers: Headers, address: str) -> Problem | None:
    """Accept the right token, or a browser that has logged in."""
    token = bearer_token(headers.getlist("authorization"))
    if token is None:
        name, place = login_place(scope, headers)
        if access.is_logged_in(cookies(headers.get("cookie", ""), name), place):
            return None
    return problem_of_refusal(access.check_token(token, address, time.monotonic()))


_PREFIX = re.compile(r"(?:/(?!\.+/)[A-Za-z0-9._~-]+)+/")


def with_prefix(scope: Scope, headers: Headers) -> Scope:
    """Put the prefix that a proxy has removed in front of the path, for the addresses in answers.

    It is named by the header X-Forwarded-Prefix, or by the server's `root_path`, which not every server puts
    in front of the path. Any client may send the header; it gets those addresses itself.
    """
    root, path = scope.get("root_path", "").rstrip("/"), scope["path"]
    if not f"{path}/".startswith(f"{root}/"):
        path = root + path
    prefix = headers.get("x-forwarded-prefix", "").rstrip("/")
    if _PREFIX.fullmatch(f"{prefix}/") and not f"{root}/".startswith(f"{prefix}/"):
        root, path = prefix + root, prefix + path
    return {**scope, "root_path": root, "path": path}


_STOP = re.compile(r"/api/v1/stop|/api/v1/robots/[^/]+/stop|/robots/[^/]+/api/v1/stop")
_LOOKS = (*_SAFE, "TRACE")


def as_stop(scope: Scope) -> Scope | None:
    """Rewrite a request for a stop so that it is routed, also one with odd slashes or an odd method."""
    path = re.sub("/+", "/", _path(scope)).rstrip("/")
    if scope["method"] in _LOOKS or not _STOP.fullmatch(path):
        return None
    root = scope.get("root_path", "")
    return {**scope, "path": root + path, "method": "POST", "woosh.method": scope["method"]}


def needs_token(path: str) -> bool:
    """Whether a path needs the token. The page's files are public; its data is not."""
    is_api = "/api/v1/" in path or path in ("/openapi.json", "/mcp")
    return is_api and not any(path.endswith(open_) for open_ in _OPEN_TO_ALL)


class SecurityMiddleware:
    """ASGI middleware that checks requests and adds security headers.

    Pages of `origins` may frame the page, and show pictures of the API.
    """

    def __init__(self, app: ASGIApp, context: WebContext, origins: Iterable[str] = ()) -> None:
        self._app, self._context, self._access = app, context, context.access
        self._origins, self._headers = frozenset(map(require_page_origin, origins)), dict(_HEADERS)
        if self._origins:
            del self._headers["x-frame-options"]  # it cannot name an origin
            self._headers["content-security-policy"] = CONTENT_POLICY.replace(
                "frame-ancestors 'none'", " ".join(("frame-ancestors", *sorted(self._origins)))
            )

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See ASGI."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        scope = with_prefix(scope, headers)
        if scope["type"] == "http":
            scope = as_stop(scope) or scope
        refusal = self._refusal(scope, headers)
        key, authorized = _end_of(scope), refusal is None and self._is_authorized(scope)
        slots = self._context.slots
        slots.request_begins(key, time.monotonic(), authorized=authorized)
        if authorized and self._access.needs_token:
            slots.remember(key[0], time.monotonic())
        send = _Sending(send)
        try:
            await self._pass(scope, receive, send, headers, refusal)
        except asyncio.CancelledError:
            if not self._context.closed:
                raise
            await _say_good_bye(scope, receive, send)  # unfinished when the server ended: not an error
        finally:
            slots.request_ends(key, time.monotonic(), authorized=authorized)

    async def _pass(
        self, scope: Scope, receive: Receive, send: Send, headers: Mapping[str, str], refusal: Problem | None
    ) -> None:
        if scope["type"] == "websocket":
            if refusal is not None:
                await _refuse_socket(refusal, receive, send)
                return
            await self._app(scope, receive, send)
            return
        own = dict(self._headers)
        page = re.match(r"https?://[^/?#]*", headers.get("referer", ""))  # an <img> sends no Origin
        if page is not None and page[0] in self._origins:
            own["cross-origin-resource-policy"] = "cross-origin"
        answer = _with_headers(scope, send, own)
        is_stop = "woosh.method" in scope  # a stop limits its body itself, after stopping the robot
        if refusal is None and not is_stop and _announced(headers) > MAX_BODY:
            refusal = _too_large()
        if refusal is not None:
            await _refused(scope, refusal, headers)(scope, receive, answer)
            return
        receive = receive if is_stop else _limited(receive)
        if scope["method"] == "HEAD":
            scope = {**scope, "method": "GET"}
            receive, answer = _head_only(receive, answer)
        await self._app(scope, receive, answer)

    def _is_authorized(self, scope: Scope) -> bool:
        """Whether the client has proved its access. With a token, requests for public paths prove nothing."""
        return not self._access.needs_token or needs_token(_path(scope))

    def _refusal(self, scope: Scope, headers: Headers) -> Problem | None:
        changes = scope["type"] == "websocket" or scope["method"] not in _SAFE
        refusal = self._access.check_headers(headers.getlist, scope.get("scheme", "http"), changes=changes)
        if refusal is not None:
            return problem_of_refusal(refusal)
        if needs_token(_path(scope)):
            return check_access(self._access, scope, headers, _end_of(scope)[0])
        return None


def _path(scope: Scope) -> str:
    return str(scope["path"].removeprefix(scope.get("root_path", "")))


def _end_of(scope: Scope) -> Key:
    """IP address and port of the peer."""
    client = scope.get("client")
    return (str(client[0]), int(client[1] or 0)) if client else ("an unknown address", 0)


def _announced(headers: Mapping[str, str]) -> int:
    text = headers.get("content-length", "0")
    return int(text) if text.isdigit() and len(text) < 16 else MAX_BODY + 1


def _too_large() -> Problem:
    return Problem(413, "the body is larger than {maximum} bytes", maximum=MAX_BODY)


def _limited(receive: Receive) -> Receive:
    got, more = 0, True
    until = time.monotonic() + BODY_SECONDS

    async def limited() -> Message:
        nonlocal got, more
        if not more:  # the body is complete; only a disconnect can follow
            return await receive()
        try:
            message = await asyncio.wait_for(receive(), max(0.0, until - time.monotonic()))
        except asyncio.TimeoutError:
            raise Problem(
                408, "the body did not arrive within {body_seconds:g} s", body_seconds=BODY_SECONDS
            ) from None
        more = bool(message.get("more_body", False))
        got += len(message.get("body", b""))
        if got > MAX_BODY:
            raise _too_large()
        return message

    return limited


def _with_headers(scope: Scope, send: Send, own: Mapping[str, str] = _HEADERS) -> Send:
    is_api = "/api/v1/" in scope["path"]

    async def answer(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for key, value in {**own, "cache-control": "no-store" if is_api else "no-cache"}.items():
                headers.setdefault(key, value)
        await send(message)

    return answer


def _head_only(receive: Receive, send: Send) -> tuple[Receive, Send]:
    """Send the answer to a GET without its body; report a disconnect to end a stream."""
    begun = False

    async def received() -> Message:
        return {"type": "http.disconnect"} if begun else await receive()

    async def answer(message: Message) -> None:
        nonlocal begun
        begun = True
        if message["type"] == "http.response.start":
            await send(message)
        elif not message.get("more_body", False):
            await send({**message, "body": b""})

    return received, answer


class _Sending:
    """`send`, which remembers whether anything was sent."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self.begun = False

    async def __call__(self, message: Message) -> None:
        self.begun = True
        await self._send(message)


async def _say_good_bye(scope: Scope, receive: Receive, send: _Sending) -> None:
    if scope["type"] != "http":
        return
    try:
        if send.begun:
            await send({"type": "http.response.body", "body": b""})
        else:
            await _refused(scope, Problem(503, "the server is shutting down"))(
                scope, receive, _with_headers(scope, send)
            )
    except (RuntimeError, OSError):
        pass  # a partly sent answer cannot be completed


def _refused(scope: Scope, refusal: Problem, headers: Mapping[str, str] = {}) -> JSONResponse:
    document = worded(refusal.document(scope["path"]), headers)
    return JSONResponse(document, refusal.status, _HEADERS_OF.get(refusal.status), MEDIA_TYPE)


async def _refuse_socket(refusal: Problem, receive: Receive, send: Send) -> None:
    await receive()
    if refusal.status in (401, 429):  # accept first: only then can our page read the reason
        await send({"type": "websocket.accept"})
        await send({"type": "websocket.close", "code": 4000 + refusal.status, "reason": refusal.text[:120]})
    else:
        await send({"type": "websocket.close", "code": 4403, "reason": refusal.text[:120]})
