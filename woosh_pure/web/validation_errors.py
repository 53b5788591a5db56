"""Sentences for the validation errors of a request: the field, the value found, and the values allowed.

The allowed values are read from the JSON schema of `models`, which /openapi.json shows, too. Pure.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rosproto.sentence import both, led, say, sentence_of
from rosproto.text import printable, short

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

Schema = Mapping[str, Any]
MAX_ERRORS = 10


def refusal(errors: Iterable[ErrorDetails], schema: Schema, parts: Schema) -> str:
    """Describe validation errors in one sentence.

    Args:
        errors: pydantic's errors, with `loc` as a path in the schema.
        schema: The schema of the checked value.
        parts: The schemas that `$ref` refers to, by name.
    """
    sentences = [_one(error, schema, parts) for error in list(errors)[:MAX_ERRORS]]
    return both(*dict.fromkeys(sentences))


def _one(error: ErrorDetails, schema: Schema, parts: Schema) -> str:
    kind, found = error["type"], error.get("input")
    names, schema = _at(error["loc"], schema, parts)
    choice = schema.get("discriminator")
    if choice is not None and isinstance(found, dict):  # the discriminator is missing or unknown
        names.append(choice["propertyName"])
        schema = {"enum": list(choice["mapping"])}
        kind, found = ("wrong", found[names[-1]]) if names[-1] in found else ("missing", None)
    name = ".".join(names) or say("the body")
    if kind == "json_invalid":
        return say("the body is not JSON: {reason}", reason=error["ctx"]["error"])
    if kind == "value_error":
        text = sentence_of(error["ctx"]["error"])
        return led(printable(name), text) if names else text
    if kind == "extra_forbidden":
        known = [each for each, part in schema.items() if not part.get("deprecated")]
        return say("{name} is not known here; known: {known}", name=_shown(names[-1]), known=known)
    if kind == "missing":
        return say("{name} is missing; allowed: {allowed}", name=name, allowed=_allowed(schema, parts))
    return say(
        "{name} is {found}; allowed: {allowed}",
        name=name,
        found=_shown(found),
        allowed=_allowed(schema, parts),
    )


def _at(way: Sequence[int | str], schema: Schema, parts: Schema) -> tuple[list[str], Schema]:
    """Return the names along the path and the schema there, or the known members if one is unknown."""
    names = []
    for step in way:
        schema = _resolved(schema, parts)
        kinds = schema.get("discriminator", {}).get("mapping", {})
        if step in kinds:  # pydantic adds the chosen kind, which is not in the request
            schema = {"$ref": kinds[step]}
            continue
        names.append(str(step))
        members = schema.get("properties", {})
        schema = members.get(step, members)
    return names, _resolved(schema, parts)


def _resolved(schema: Schema, parts: Schema) -> Schema:
    """Resolve a reference, and an optional schema to the one that is not null."""
    chosen = [one for one in schema.get("anyOf", ()) if one != {"type": "null"}]
    if len(chosen) == 1:
        schema = {**schema, **chosen[0]}
    if "$ref" in schema:
        schema = parts[str(schema["$ref"]).rpartition("/")[2]]
    return schema


def _shown(value: object) -> str:
    """Return a value as JSON, if it is short."""
    return short(printable(json.dumps(value, ensure_ascii=False, default=lambda _: "...")))


def _allowed(schema: Schema, parts: Schema) -> str:
    schema = _resolved(schema, parts)
    kind = schema.get("type")
    if "const" in schema or "enum" in schema:
        return say("{values}", values=[_shown(each) for each in schema.get("enum", [schema.get("const")])])
    if kind == "boolean":
        return say("true or false")
    if kind in ("number", "integer"):
        return _range(schema)
    if kind == "string" and "maxLength" in schema:
        minimum, maximum = schema.get("minLength", 0), schema["maxLength"]
        return say("a text of {minimum} to {maximum} characters", minimum=minimum, maximum=maximum)
    if kind == "string":
        return say("a text")
    members = schema.get("properties", {})
    known = [name for name, part in members.items() if not part.get("deprecated")]
    return say("a JSON object with {known}", known=known) if known else say("a JSON object")


def _range(schema: Schema) -> str:
    whole = say("a whole number") if schema["type"] == "integer" else say("a number")
    low, high = schema.get("minimum"), schema.get("maximum")
    above = schema.get("exclusiveMinimum")
    if high is None or (low is None and above is None):
        return whole
    said = (
        say("{number} from {low:.9g} to {high:.9g}", number=whole, low=low, high=high)
        if above is None
        else say("{number} above {low:.9g} and up to {high:.9g}", number=whole, low=above, high=high)
    )
    return say("{number} {unit}", number=said, unit=schema["x-unit"]) if "x-unit" in schema else said
