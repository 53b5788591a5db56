"""The content types of the page's files do not depend on this computer."""

from __future__ import annotations

import mimetypes
import os
import re

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


def test_each_module_is_fetched_at_once() -> None:
    """The page that is served names all of them, and the file need not."""
    path = PAGE / "index.html"
    scope = {"type": "http", "method": "GET", "headers": []}
    text = bytes(PageFiles(directory=PAGE).file_response(path, os.stat(path), scope).body).decode()
    named = re.findall(r'<link rel="modulepreload" href="\./js/(\w+\.js)">', text)
    assert sorted([*named, "early_stop.js", "main.js"]) == sorted(p.name for p in (PAGE / "js").iterdir())
    assert text.index("modulepreload") > text.index("app.css"), "what draws the page comes first"
