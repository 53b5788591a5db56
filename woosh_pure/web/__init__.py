"""The robot in a browser, and a REST API for any language: run `woosh web`, or mount it in your own
application.

    app = FastAPI()
    app.mount("/robot", woosh_pure.web.app(chassis))

Needs the extra `web`: pip install ".[web]".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.admission import MAX_CLIENTS
from woosh_pure.web.access import AccessRules

if TYPE_CHECKING:
    from fastapi import FastAPI

    from woosh_pure.chassis import Chassis
    from woosh_pure.sim import SimulatedChassis
    from woosh_pure.web.marks import NamedPlace

__all__ = ["app", "close"]


def app(
    chassis: Chassis | Mapping[str, Chassis],
    *,
    token: str | None = None,
    allow_driving: bool = False,
    origins: Iterable[str] = (),
    hosts: Iterable[str] = (),
    name: str | None = None,
    marks: Iterable[NamedPlace] | Mapping[str, Iterable[NamedPlace]] = (),
    recordings: str | Path | None = None,
    missions: str | Path | None = None,
    max_clients: int = MAX_CLIENTS,
    simulator: SimulatedChassis | Mapping[str, SimulatedChassis] | None = None,
) -> FastAPI:
    """Return the page and the API of one or more robots as an ASGI application to serve or to mount.

    The application starts no thread and no connection before the first request. Open the Chassis in the
    lifespan of your application. At the end, call `close` first, and then close the Chassis.

    Args:
        chassis: The robot, or several by name. Paths without a robot's name mean the first one.
        token: The secret that every request must carry, at least 8 characters. With None, everybody who can
            reach the server may use it.
        allow_driving: Whether a page may drive by velocity, which bypasses the chassis's obstacle avoidance.
        origins: Origins of other servers' pages that may send requests, as "https://host:port".
        hosts: Host names under which the server may be reached, besides localhost and IP addresses.
        name: The robot's name, if there is only one robot.
        marks: Marks to show and to drive to: a `MarkFile`, in which the page and the API save what they
            change, or any objects with `name` and `pose`; changes of those last as long as the application.
            The chassis cannot list its own. With several robots, a mapping from robot name to marks.
        recordings: Folder for recorded bags. With None, the first recording creates a temporary folder.
        missions: Folder of mission files; None for that of each Chassis, the user's.
        max_clients: The most pages that show the robots at a time.
        simulator: The simulated chassis that `chassis` drives, or those of several by the robot's name: the
            page and the API can then press its emergency stop, put obstacles in its way, and so on.

    Raises:
        ImportError: The extra `web` is not installed.
        ValueError: The token is too easy to guess, an origin is not valid, a name cannot be part of a URL,
            or nothing can be written to `recordings`.
    """
    from woosh_pure.web.optional_libraries import require

    require()
    from woosh_pure.web.application import build
    from woosh_pure.web.context import WebContext
    from woosh_pure.web.marks import MarkList
    from woosh_pure.web.recordings import require_folder
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
    access = AccessRules(token, origins, hosts)
    folder = None if recordings is None else require_folder(Path(recordings))
    of_all = None if isinstance(marks, Mapping) else MarkList(marks)
    simulators = simulator if isinstance(simulator, Mapping) else dict.fromkeys(list(robots)[:1], simulator)
    made = {}
    for each, one in robots.items():
        if missions is not None:
            one.missions.files = Path(missions)
        own = folder if folder is None or len(robots) == 1 else folder / each
        if own is not None:
            own.mkdir(exist_ok=True)
        own_marks = of_all or MarkList(marks.get(each, ()) if isinstance(marks, Mapping) else ())
        made[each] = Robot(each, one, marks=own_marks, recordings=own, simulator=simulators.get(each))
    context = WebContext(made, access, allow_driving=allow_driving, max_viewers=max_clients)
    return build(context, origins=origins)


def close(app: FastAPI, why: str = "the server is shutting down") -> None:
    """End driving by velocity and the recordings of an application made by `app`, without waiting."""
    app.state.context.close(why)
