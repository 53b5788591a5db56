"""A hook of MkDocs: no blank lines and no indentation in what it writes, but where they are shown.

A third of a page of the reference is such space, and the pages are read on phones beside a robot.
"""

from __future__ import annotations

import re
from typing import Any

_SHOWN_OR_BLANK = re.compile(r"(<(?P<tag>pre|script|style|textarea)\b.*?</(?P=tag)>)|\s*\n\s*", re.DOTALL)


def on_post_page(output: str, **_: Any) -> str:
    """The page without blank lines and indentation."""
    return _SHOWN_OR_BLANK.sub(lambda found: found[1] or "\n", output)
