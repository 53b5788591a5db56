"""GET access, POST and DELETE login: the page's token is kept in a cookie that scripts cannot read."""

from __future__ import annotations

import time
from typing import Any

from fastapi import APIRouter, Request, Response

from woosh_pure.web import models
from woosh_pure.web.access import COOKIE
from woosh_pure.web.api.dependencies import address_of, context_of, problems
from woosh_pure.web.middleware import token_of
from woosh_pure.web.problems import Problem

__all__ = ["server_router"]

server_router = APIRouter(tags=["access"], responses=problems(401, 403, 429))


def get_access(request: Request) -> dict[str, Any]:
    """Whether a token is needed, and what this client may do. Needs no token itself."""
    context = context_of(request)
    given = token_of(dict(request.headers))
    refusal = context.access.check_token(given, address_of(request), time.monotonic())
    return {
        "needs_token": context.access.needs_token,
        "logged_in": refusal is None,
        "allow_driving": context.allow_driving,
        "robots": list(context.robots) if refusal is None else [],
    }


def log_in(body: models.LoginRequest, request: Request, response: Response) -> dict[str, Any]:
    """Store the token in a cookie."""
    context = context_of(request)
    refusal = context.access.check_token(body.token, address_of(request), time.monotonic())
    if refusal is not None:
        raise Problem(refusal.status, refusal.text)
    response.set_cookie(
        COOKIE,
        body.token,
        path=_place(request),
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    return {"logged_in": True}


def log_out(request: Request, response: Response) -> dict[str, Any]:
    """Delete the token's cookie in this browser."""
    response.delete_cookie(COOKIE, path=_place(request))
    return {"logged_in": False}


def _place(request: Request) -> str:
    return str(request.scope.get("root_path", "")) or "/"


server_router.add_api_route("/access", get_access, response_model=models.AccessAnswer)
server_router.add_api_route("/login", log_in, methods=["POST"], response_model=models.Answer)
server_router.add_api_route("/login", log_out, methods=["DELETE"], response_model=models.Answer)
