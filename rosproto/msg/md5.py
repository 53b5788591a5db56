"""The md5sum of a definition, which peers compare before they exchange messages.

Source: wiki.ros.org/ROS/Technical%20Overview (section "msg MD5 sums"); gentools.py in genmsg.
"""

from __future__ import annotations

from collections.abc import Callable

from rosproto.msg.spec import MessageSpec

try:
    # hashlib's own fallback, without loading OpenSSL.
    from _md5 import md5  # type: ignore[import-not-found]
except ImportError:
    from hashlib import md5


def md5_text(spec: MessageSpec, md5sum_of: Callable[[str], str]) -> str:
    """The text that is hashed: constants first, then fields, without comments.

    A message type is replaced by its md5sum, **without** the array suffix: `U u`, `U[] u` and `U[3] u` hash
    alike. Builtin arrays keep theirs, aliases keep their name (`byte b` is not `int8 b`), and constants keep
    their literal as written (`True` is not `1`).

    Args:
        spec: The message.
        md5sum_of: Returns the md5sum of a message type by full name.
    """
    lines = [f"{constant.type} {constant.name}={constant.text}" for constant in spec.constants]
    for field in spec.fields:
        kind = str(field.type) if field.type.is_builtin else md5sum_of(field.type.base)
        lines.append(f"{kind} {field.name}")
    return "\n".join(lines)


def md5sum_of_texts(*texts: str) -> str:
    """The md5sum of one text, or of a service's two with nothing between them."""
    digest = md5(usedforsecurity=False)  # an identity, not for security: works if FIPS forbids md5
    for text in texts:
        digest.update(text.encode("utf-8", "surrogateescape"))
    result: str = digest.hexdigest()
    return result
