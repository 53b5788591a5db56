"""Puts the ASGI application together: routes, error handlers, middleware, and the page's files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from fastapi import Depends, FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from fastapi.routing import APIRoute
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException
from starlette.middleware.cors import CORSMiddleware
from starlette.middleware.gzip import GZipMiddleware
from starlette.types import ASGIApp

from rosproto.errors import RosError
from rosproto.text import printable
from rosproto.version import __version__
from woosh_pure.web import models
from woosh_pure.web.api import commands, marks, readings, session, stop
from woosh_pure.web.api.dependencies import named_robot
from woosh_pure.web.context import WebContext
from woosh_pure.web.middleware import SecurityMiddleware
from woosh_pure.web.problems import MEDIA_TYPE, Problem, problem_of
from woosh_pure.web.snapshot import text_of

PAGE = Path(__file__).parent / "page"
_ROBOT = (
    *(readings.state, commands.goals, stop.router, readings.maps, readings.pictures, readings.feeds),
    *(readings.journal, marks.router, commands.lease, commands.recordings, session.viewers),
)
_SERVER = (readings.robots, session.login)
DESCRIPTION = (
    "A Woosh chassis for any language. Units are m, rad, s; poses are in the map. Nothing moves by a GET. "
    "POST /api/v1/stop is no emergency stop. Errors are application/problem+json."
)


class _Json(JSONResponse):
    """JSON in which what is no number (NaN, infinite) is null."""

    def render(self, content: Any) -> bytes:
        """See Starlette."""
        return text_of(content).encode()


def build(context: WebContext, *, origins: tuple[str, ...] = ()) -> FastAPI:
    """The application for these robots and rules. It starts nothing."""
    app = FastAPI(
        title="woosh",
        version=__version__,
        description=DESCRIPTION,
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
    app.add_middleware(SecurityMiddleware, context=context)
    if origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=list(origins),
            allow_methods=["GET", "POST", "PATCH", "DELETE"],
            allow_headers=["authorization", "content-type", "x-woosh-session"],
        )
    _say_problems(app)
    return app


def _page() -> ASGIApp:
    """The page's files, compressed: that is seconds on a slow link."""
    return GZipMiddleware(StaticFiles(directory=PAGE, html=True), minimum_size=500)


def _operation(route: APIRoute) -> str:
    """The operation's name in generated clients; it has a suffix if the path names a robot."""
    return route.name + ("_of_robot" if "{robot}" in route.path_format else "")


def _say_problems(app: FastAPI) -> None:
    """Describe errors in /openapi.json as problem+json, in place of FastAPI's own format."""
    made = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is not None:
            return app.openapi_schema
        schema = made()
        parts = schema["components"]["schemas"]
        parts.pop("HTTPValidationError", None)
        parts.pop("ValidationError", None)
        parts["StopRequest"] = models.StopRequest.model_json_schema()
        parts["ProblemDocument"] = models.ProblemDocument.model_json_schema()
        content = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/ProblemDocument"}}}
        for path in schema["paths"].values():
            for operation in path.values():
                _leave_out_null(operation)
                found = operation["responses"].get("422")
                if found is not None:
                    operation["responses"]["422"] = {"description": "makes no sense", "content": content}
        return schema

    app.openapi = openapi  # type: ignore[method-assign]


def _leave_out_null(operation: dict[str, Any]) -> None:
    """Remove null from the schema of an optional body: it may be left out, but `null` is not accepted."""
    for content in operation.get("requestBody", {}).get("content", {}).values():
        schema = content["schema"]
        kinds = [kind for kind in schema.get("anyOf", ()) if kind != {"type": "null"}]
        if len(kinds) == 1:
            content["schema"] = kinds[0]


def _answer(request: Request, problem: Problem) -> JSONResponse:
    return JSONResponse(problem.document(request.url.path), problem.status, media_type=MEDIA_TYPE)


async def _on_error(request: Request, error: Exception) -> JSONResponse:
    return _answer(request, problem_of(error))


async def _on_invalid(request: Request, error: Exception) -> JSONResponse:
    wrong = []
    for one in getattr(error, "errors", list)()[:10]:
        if body := _wrong_body(request, one):
            wrong.append(body)
            continue
        where = ".".join(str(part) for part in one.get("loc", ()) if part != "body")[:100]
        wrong.append(f"{where}: {one.get('msg', '')}" if where else str(one.get("msg", "")))
    return _answer(request, Problem(422, "; ".join(wrong)[:1000] or "the request makes no sense", "invalid"))


def _wrong_body(request: Request, error: dict[str, Any]) -> str:
    """What is wrong with a body as a whole; "" if it is JSON, as it should be."""
    if error.get("type") == "json_invalid":
        reason, at = error.get("ctx", {}).get("error", ""), error.get("loc", ("", "?"))[-1]
        return f"the body is no JSON: {reason} (at character {at})"
    if tuple(error.get("loc", ())) != ("body",):
        return ""
    if error.get("type") == "missing":
        return "a body is missing: send a JSON object, with the header content-type: application/json"
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind == "application/json":
        return ""
    return f"the body is {printable(kind[:60]) or 'of no type'}: send content-type: application/json"


async def _on_http(request: Request, error: Exception) -> JSONResponse:
    status = int(getattr(error, "status_code", 500))
    if methods := _other_methods(request):  # the page's files stand behind the API, and know only their own
        status = 405
    words = {
        404: "there is nothing at this address; /openapi.json describes the API",
        405: f"this address takes {' and '.join(methods)}, not {request.method}"
        if methods
        else "this address does not take this method",
    }
    text = words.get(status) or str(getattr(error, "detail", "")) or "the request was refused"
    answer = _answer(request, Problem(status, text))
    if methods:
        answer.headers["allow"] = ", ".join(methods)
    return answer


def _other_methods(request: Request) -> list[str]:
    """The methods of the API at this path, if the request's own is not one of them."""
    path = request.url.path.removeprefix(str(request.scope.get("root_path", "")))
    path = re.sub(r"^/robots/[^/]+(?=/api/v1/)", "", path)
    for template, operations in request.app.openapi()["paths"].items():
        if re.fullmatch(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(template)), path):
            methods = sorted(operation.upper() for operation in operations)
            return [] if request.method in methods else methods
    return []
