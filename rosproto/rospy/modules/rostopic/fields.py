"""Selects a part of a message by a pattern like "/poses[1:]/pose/position/x"."""

import sys

_PARTS = ("start", "stop", "step")


def msgevalgen(pattern):
    """Return a function that extracts a part of a message; None for an empty or malformed pattern.

    The function returns None for a missing field or element. Errors are reported on stderr.
    """
    steps = []
    for part in (part for part in pattern.split("/") if part):
        name, bracket, rest = part.partition("[")
        if not bracket:
            steps.append((name, None))
            continue
        if not rest.endswith("]"):
            _tell("missing closing ']' in slice spec '%s'" % part)
            return None
        try:
            steps.append((name, _index(rest[:-1])))
        except ValueError as error:
            _tell("field '%s' has invalid slice argument '%s': %s" % (name, rest[:-1], error))
            return None
    return (lambda message: _walk(message, steps, pattern)) if steps else None


def _walk(value, steps, pattern):
    for number, (name, index) in enumerate(steps, 1):
        try:
            value = getattr(value, name)
        except AttributeError:
            _tell("no field named %s in %s" % (name, pattern))
            return None
        if index is None:
            continue
        try:
            value = value.__getitem__(index)
        except IndexError as error:
            _tell("%s: %s" % (error, pattern))
            return None
        if isinstance(value, list):  # of messages: the rest of the pattern applies to each
            return [_walk(one, steps[number:], pattern) for one in value]
    return value


def _index(text):
    """The Python index or slice between brackets.

    Raises:
        ValueError: The text is neither an index nor a slice.
    """
    if not text:
        raise ValueError("empty array index")
    if ":" not in text:
        return _integer(text, "array index step")
    parts = text.split(":")
    bounds = [
        _integer(part, "slice " + name) if part else None for part, name in zip(parts, _PARTS)
    ]  # the first malformed one is reported
    if len(parts) > len(_PARTS):
        raise ValueError("too many slice arguments")
    return slice(*bounds)


def _integer(text, what):
    try:
        return int(text)
    except ValueError:
        raise ValueError("non-integer %s '%s'" % (what, text)) from None


def _tell(text):
    print(text, file=sys.stderr)
