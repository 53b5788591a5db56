"""Make a `DefinitionLibrary` of a full text from a connection header or bag; the text is untrusted."""

from __future__ import annotations

from rosproto.errors import DefinitionError
from rosproto.msg.definition_limits import DefinitionLimits, check_length, check_limits
from rosproto.msg.full_text import split_full_text
from rosproto.msg.library import DefinitionLibrary
from rosproto.msg.parser import parse_message


def library_from_full_text(
    name: str,
    text: str,
    *,
    base: DefinitionLibrary | None = None,
    limits: DefinitionLimits | None = None,
) -> DefinitionLibrary:
    """Definitions from a full text, as in a connection header or bag.

    The text is untrusted: its size is limited, names must be legal identifiers, and no type may contain
    itself. Code may be generated from the result.

    Args:
        name: "package/Type" of the first definition.
        text: Its definition and that of each type it uses, separated by "=" * 80 and "MSG: package/Type".
        base: Library of types that the text does not define; none by default.
        limits: Maximum sizes.

    Raises:
        DefinitionError: The text is not legal, not complete or exceeds a limit.
    """
    limits = limits or DefinitionLimits()
    if len(text) > limits.text_bytes:
        raise DefinitionError(
            f"{name[:300]}: the full text has {len(text)} characters, at most {limits.text_bytes} allowed; "
            f"the sender is broken or hostile, or raise DefinitionLimits.text_bytes"
        )
    parts = split_full_text(text, name)
    if len(parts) > limits.types:
        raise DefinitionError(
            f"{name}: the full text defines {len(parts)} types, at most {limits.types} allowed; "
            f"the sender is broken or hostile, or raise DefinitionLimits.types"
        )
    library = DefinitionLibrary(base=base)
    for part, body in parts.items():
        check_length(part, body, limits)
        library.add(parse_message(body, part, lenient=True))
    if "roslib/Header" in parts and "std_msgs/Header" not in parts:
        # Texts from before REP 100 (in old bags) use this name; `Header` now means std_msgs/Header.
        library.add(parse_message(parts["roslib/Header"], "std_msgs/Header", lenient=True))
    check_limits(list(parts), library.message, limits)
    return library
