"""Completes /openapi.json: common errors, the token, and no null where a value cannot be null. Also finds the
schema of a request.
"""

from __future__ import annotations

import re
from typing import Any

from fastapi import FastAPI, Request

from woosh_pure.web import models
from woosh_pure.web.api.dependencies import problems
from woosh_pure.web.http_errors import MEDIA_TYPE
from woosh_pure.web.middleware import needs_token
from woosh_pure.web.validation_errors import Schema

TEXT = (
    "A Woosh chassis for any language. Units are m, rad, s; poses are in the map. Nothing moves by a GET, "
    "and HEAD works wherever GET does. POST /api/v1/stop is not an emergency stop; it stops the robot "
    "before it reports problems, so a stop that is answered with an error has been sent, too. A DELETE "
    "deletes: the next one is answered with 404. Errors are application/problem+json. Sentences are English, "
    "or Chinese with `Accept-Language: zh`."
)
_OF_ALL, _OF_CHANGES, _OF_BODIES = (413, 421, 429, 500, 503), (403,), (408, 422)
_SCHEMES = {"token": {"type": "http", "scheme": "bearer", "description": "browsers may POST it to login"}}


def describe(app: FastAPI) -> None:
    """Complete the description that FastAPI generates from the routes."""
    made = app.openapi
    secret = app.state.context.access.needs_token

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is not None:
            return app.openapi_schema
        document = made()
        parts = document["components"]["schemas"]
        for name in ("HTTPValidationError", "ValidationError"):  # FastAPI's own format
            parts.pop(name, None)
        for model in (models.StopRequest, models.ProblemDocument):
            parts[model.__name__] = model.model_json_schema()
        document["components"]["securitySchemes"] = _SCHEMES
        if secret:
            document["security"] = [{name: []} for name in _SCHEMES]
        for path, item in document["paths"].items():
            for method, operation in item.items():
                _complete(operation, path, method, secret=secret)
        return document

    app.openapi = openapi  # type: ignore[method-assign]


def _complete(operation: dict[str, Any], path: str, method: str, *, secret: bool) -> None:
    answers, statuses = operation["responses"], set(_OF_ALL)
    if secret and needs_token(path):
        statuses.add(401)
    elif secret:
        operation["security"] = []
    if "{" in path:
        statuses.add(404)
    if method != "get":
        statuses.update(_OF_CHANGES)
    if "requestBody" in operation:
        statuses.update(_OF_BODIES)
    if "422" in answers:  # FastAPI describes its default format
        statuses.add(422)
    for status, answer in problems(*statuses).items():
        if MEDIA_TYPE not in answers.get(str(status), {}).get("content", {}):
            answers[str(status)] = answer
    operation["responses"] = dict(sorted(answers.items()))
    for content in operation.get("requestBody", {}).get("content", {}).values():
        content["schema"] = _without_null(content["schema"])
    for parameter in operation.get("parameters", ()):
        parameter["schema"] = _without_null(parameter["schema"])


def _without_null(schema: Schema) -> Schema:
    """Remove null from a schema: an optional body or parameter may be left out, but not be null."""
    kinds = [kind for kind in schema.get("anyOf", ()) if kind != {"type": "null"}]
    return kinds[0] if len(kinds) == 1 else schema


def _item(request: Request) -> Schema:
    """Return the operations at the path of a request, by method."""
    path = request.url.path.removeprefix(str(request.scope.get("root_path", "")))
    path = re.sub(r"^/robots/[^/]+(?=/api/v1/)", "", path)
    for template, item in request.app.openapi()["paths"].items():
        if re.fullmatch(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(template)), path):
            return dict(item)
    return {}


def methods_at(request: Request) -> list[str]:
    """Return the API's methods at this path."""
    methods = {method.upper() for method in _item(request)}
    return sorted(methods | {"HEAD"} if "GET" in methods else methods)


def schema_of(request: Request, where: str) -> Schema:
    """Return the schema of a part of this request.

    Args:
        where: "body", or the location of parameters: "query", "path", "header".
    """
    operation = _item(request).get(request.method.lower(), {})
    if where == "body":
        content = operation.get("requestBody", {}).get("content", {})
        return dict(content.get("application/json", {}).get("schema", {}))
    return {
        "properties": {p["name"]: p["schema"] for p in operation.get("parameters", ()) if p["in"] == where}
    }


def parts_of(request: Request) -> Schema:
    """Return the schemas that `$ref` refers to, by name."""
    return dict(request.app.openapi()["components"]["schemas"])
