"""The robot in a browser, and a REST door for any language: `woosh web`, or mounted in an application of
yours.

    app = FastAPI()
    app.mount("/robot", woosh_pure.web.app(chassis))

Needs the extra `web`: pip install 'woosh-pure[web]'.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from woosh_pure.web.access import Access

if TYPE_CHECKING:
    from fastapi import FastAPI

    from woosh_pure.chassis import Chassis

__all__ = ["Access", "app", "close"]


def app(
    chassis: Chassis | Mapping[str, Chassis],
    *,
    token: str | None = None,
    allow_driving: bool = False,
    origins: Iterable[str] = (),
    hosts: Iterable[str] = (),
    name: str | None = None,
    marks: Iterable[Any] = (),
    recordings: str | Path | None = None,
) -> FastAPI:
    """The page and the API of one robot, or of several, as an ASGI application to serve or to mount.

    It starts nothing: no thread, no connection, before somebody asks. The Chassis is yours: open it before,
    in the lifespan of your application, and close it afterwards (`close` first ends what the web has begun).

    Args:
        chassis: The robot; or several by their names, the first one being that of the plain paths.
        token: What every request must carry, at least 8 letters; None lets everybody in who reaches it.
        allow_driving: Whether a page may drive by velocity, past the chassis's obstacle avoidance.
        origins: Pages of other servers that may ask, as "https://host:port".
        hosts: Names by which the server may be called, beside localhost and addresses in numbers.
        name: Of the robot, where it is one.
        marks: To be shown and driven to: of a `MarkFile`, or anything with `name` and `pose`. The chassis
            cannot list its own. Of several robots: a mapping by their names.
        recordings: Folder of recorded bags; None makes a temporary one with the first.

    Raises:
        ImportError: The extra `web` is not installed.
        ValueError: A token that can be guessed, an origin that is none, a name that cannot stand in an
            address.
    """
    from woosh_pure.web.extra import require

    require()
    from woosh_pure.web.build import build
    from woosh_pure.web.context import WebContext
    from woosh_pure.web.robot import Robot

    robots = dict(chassis) if isinstance(chassis, Mapping) else {name or "robot": chassis}
    if not robots:
        raise ValueError("no robot is given")
    for each in robots:
        if not (0 < len(each) <= 100) or any(
            c in "/?#%\\" or c.isspace() or not c.isprintable() for c in each
        ):
            raise ValueError(
                f"robot name {each!r}: it stands in addresses, so no blanks and none of / ? # % \\"
            )
    origins = tuple(origins)
    access = Access(token, origins, hosts)
    folder = None if recordings is None else Path(recordings)
    made = {
        each: Robot(
            each,
            one,
            marks=marks.get(each, ()) if isinstance(marks, Mapping) else marks,
            recordings=folder if folder is None or len(robots) == 1 else folder / each,
        )
        for each, one in robots.items()
    }
    return build(WebContext(made, access, allow_driving=allow_driving), origins=origins)


def close(app: FastAPI, why: str = "the server ends") -> None:
    """End what an application of `app` has begun and moves the robot by velocity, at once; and its
    recordings.
    """
    app.state.context.close(why)
