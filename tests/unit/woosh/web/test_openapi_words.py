"""The Chinese of the page of the API: each description of openapi.json, and no other."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="needs the extra web")

from woosh_pure.web.access import AccessRules
from woosh_pure.web.application import PAGE, build
from woosh_pure.web.context import WebContext


def descriptions(part: object) -> Iterator[str]:
    """The texts of a document, and the names of its groups."""
    if isinstance(part, list):
        for each in part:
            yield from descriptions(each)
    elif isinstance(part, dict):
        for key, value in part.items():
            if key == "description" and isinstance(value, str):
                yield value
            elif key == "tags":
                yield from value
            elif "/robots/{robot}/" not in key:
                yield from descriptions(value)


def words(path: Path) -> dict[str, str]:
    """The object literal of a module, one member a line."""
    rows = re.findall(r"^  (.*),$", path.read_text("utf-8"), re.MULTILINE)
    return {key: value for row in rows for key, value in json.loads(f"{{{row}}}").items()}


def test_each_description_has_its_chinese() -> None:
    app = build(WebContext({}, AccessRules("Kd83-hsa2-Pq"), allow_driving=True, max_viewers=8))
    document = app.openapi()
    document.get("components", {}).pop("securitySchemes")
    found, chinese = set(descriptions(document)), words(PAGE / "docs/words_zh.js")
    assert {text for text in found if len(text) > 1} - set(chinese) == set()
    assert set(chinese) - found == set()
