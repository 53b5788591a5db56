"""The content types of the page's files do not depend on this computer."""

from __future__ import annotations

import mimetypes
import os

import pytest

pytest.importorskip("fastapi", reason="fastapi is not installed")

from woosh_pure.web.application import PAGE, PageFiles


def test_a_module_is_javascript_whatever_the_registry_says(monkeypatch: pytest.MonkeyPatch) -> None:
    """On Windows other programs may have registered `.js` as text/plain, which no browser runs as a module."""
    mimetypes.init()
    monkeypatch.setitem(mimetypes.types_map, ".js", "text/plain")
    path = PAGE / "js" / "main.js"
    scope = {"type": "http", "method": "GET", "headers": []}
    response = PageFiles(directory=PAGE).file_response(path, os.stat(path), scope)
    assert response.headers["content-type"] == "text/javascript; charset=utf-8"
    again = [(b"if-none-match", response.headers["etag"].encode())]
    unchanged = PageFiles(directory=PAGE).file_response(path, os.stat(path), {**scope, "headers": again})
    assert unchanged.status_code == 304
    assert "content-type" not in unchanged.headers
