"""Puts the ASGI application together: routes, error handlers, middleware, and the page's files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import Depends, FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from fastapi.routing import APIRoute
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException
from starlette.middleware.cors import CORSMiddleware
from starlette.middleware.gzip import GZipMiddleware
from starlette.responses import HTMLResponse, Response
from starlette.types import ASGIApp

from rosproto.errors import RosError
from rosproto.sentence import both, say
from rosproto.text import printable
from rosproto.version import __version__
from woosh_pure.web.api import commands, marks, missions, readings, session, stop
from woosh_pure.web.api.dependencies import named_robot
from woosh_pure.web.context import WebContext
from woosh_pure.web.http_errors import MEDIA_TYPE, Problem, problem_of, worded
from woosh_pure.web.middleware import SecurityMiddleware
from woosh_pure.web.openapi import TEXT, describe, methods_at, parts_of, schema_of
from woosh_pure.web.snapshot import text_of
from woosh_pure.web.validation_errors import refusal

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

PAGE = Path(__file__).parent / "page"
_ROBOT = (
    *(
        readings.state,
        commands.goals,
        stop.router,
        readings.maps,
        readings.scenes,
        readings.pictures,
        readings.feeds,
    ),
    *(readings.journal, marks.router, missions.router, commands.lease, commands.recordings, session.viewers),
    commands.simulator,
)
_SERVER = (readings.robots, session.login)


class _Json(JSONResponse):
    """JSON in which NaN and infinity are null."""

    def render(self, content: object) -> bytes:
        """See Starlette."""
        return text_of(content).encode()


def build(context: WebContext, *, origins: tuple[str, ...] = ()) -> FastAPI:
    """Return the application for these robots and rules. It starts no thread and no connection."""
    app = FastAPI(
        title="woosh",
        version=__version__,
        description=TEXT,
        docs_url=None,
        redoc_url=None,
        generate_unique_id_function=_operation,
        default_response_class=_Json,
    )
    app.state.context = context
    for routes in _SERVER:
        app.include_router(routes, prefix="/api/v1")
    for routes in _ROBOT:
        app.include_router(routes, prefix="/api/v1")
        app.include_router(routes, prefix="/api/v1/robots/{robot}", dependencies=[Depends(named_robot)])
        app.include_router(routes, prefix="/robots/{robot}/api/v1", include_in_schema=False)
    for routes in _SERVER:  # the page of one robot uses paths relative to its own address
        app.include_router(routes, prefix="/robots/{robot}/api/v1", include_in_schema=False)
    for kind in (Problem, RosError, ValueError, KeyError, Exception):
        app.add_exception_handler(kind, _on_error)
    app.add_exception_handler(RequestValidationError, _on_invalid)
    app.add_exception_handler(HTTPException, _on_http)
    if PAGE.is_dir():
        for name in context.robots:
            app.mount(f"/robots/{name}", _page())
        app.mount("/", _page())
    app.add_middleware(SecurityMiddleware, context=context, origins=origins)
    if origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=list(origins),
            allow_methods=["GET", "POST", "PUT", "PATCH", "DELETE"],
            allow_headers=["authorization", "content-type", "idempotency-key", "x-woosh-session"],
            expose_headers=["location"],
        )
    describe(app)
    return app


_CONTENT_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}


class PageFiles(StaticFiles):
    """The page's files with content types of our own.

    Windows' registry may call a `.js` file text/plain, and a browser runs no module of that type.
    """

    def file_response(self, full_path: str | os.PathLike[str], *args: Any, **kwargs: Any) -> Response:
        """Serve one file."""
        if os.path.samefile(full_path, PAGE / "index.html"):
            return HTMLResponse(_index())
        response = super().file_response(full_path, *args, **kwargs)
        kind = _CONTENT_TYPES.get(os.path.splitext(full_path)[1])
        if kind is not None and "content-type" in response.headers:  # a 304 has none
            response.headers["content-type"] = kind
        return response


def _index() -> str:
    """The page with its modules named: each is fetched at once, not when the one that needs it has come."""
    names = sorted({path.name for path in (PAGE / "js").glob("*.js")} - {"early_stop.js", "main.js"})
    links = "".join(f'<link rel="modulepreload" href="./js/{name}">\n  ' for name in names)
    main = '<script type="module"'
    return (PAGE / "index.html").read_text("utf-8").replace(main, links + main, 1)


def _page() -> ASGIApp:
    """Serve the page's files compressed, which saves seconds on a slow link."""
    return GZipMiddleware(PageFiles(directory=PAGE, html=True), minimum_size=500)


def _operation(route: APIRoute) -> str:
    """Return the operation's name in generated clients, with a suffix if the path names a robot."""
    return route.name + ("_of_robot" if "{robot}" in route.path_format else "")


def _answer(request: Request, problem: Problem) -> JSONResponse:
    document = worded(problem.document(request.url.path), request.headers)
    return JSONResponse(document, problem.status, media_type=MEDIA_TYPE)


async def _on_error(request: Request, error: Exception) -> JSONResponse:
    problem = problem_of(error)
    if problem.kind == "value" and request.method == "GET":  # the value came from the robot, not the client
        problem.status = 502
    return _answer(request, problem)


async def _on_invalid(request: Request, error: Exception) -> JSONResponse:
    parts, wrong = parts_of(request), []
    errors: list[ErrorDetails] = getattr(error, "errors", list)()
    for one in errors[:10]:
        where, *way = one["loc"]
        inside = one.copy()
        inside["loc"] = tuple(way)
        sentence = _wrong_body(request, one) or refusal([inside], schema_of(request, str(where)), parts)
        wrong.append(sentence)
    return _answer(request, Problem(422, both(*dict.fromkeys(wrong)), "invalid"))


def _wrong_body(request: Request, error: ErrorDetails) -> str:
    """Describe why a body is not JSON; "" if it is JSON."""
    if error.get("type") == "json_invalid":
        reason, at = error.get("ctx", {}).get("error", ""), error.get("loc", ("", "?"))[-1]
        return say("the body is not JSON: {reason} (at character {at})", reason=say(reason), at=at)
    if tuple(error.get("loc", ())) != ("body",):
        return ""
    if error.get("type") == "missing":
        return say("a body is missing: send a JSON object, with the header content-type: application/json")
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind == "application/json":
        return ""
    if not kind:
        return say("the body has no type: send content-type: application/json")
    return say("the body is {kind}: send content-type: application/json", kind=printable(kind[:60]))


async def _on_http(request: Request, error: Exception) -> JSONResponse:
    status = int(getattr(error, "status_code", 500))
    methods = methods_at(request)
    if methods and request.method not in methods:  # other paths are files of the page
        said = say(
            "this address accepts {methods}, not {method}", methods=methods, method=printable(request.method)
        )
        answer = _answer(request, Problem(405, said))
        answer.headers["allow"] = ", ".join(methods)
        return answer
    words = {
        400: "the body is not JSON in UTF-8, or is nested too deeply",
        404: "this address does not exist; see /docs/ for the API",
        405: "this address does not take this method",
    }
    text = words.get(status) or str(getattr(error, "detail", "")) or "the request was refused"
    return _answer(request, Problem(422, text, "invalid") if status == 400 else Problem(status, text))
