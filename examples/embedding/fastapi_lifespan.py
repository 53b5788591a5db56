"""FastAPI routes over one Chassis that lives as long as the server (`pip install fastapi uvicorn httpx`).

    python examples/embedding/fastapi_lifespan.py --stay          # a simulated robot; http://127.0.0.1:8000/docs
    python examples/embedding/fastapi_lifespan.py --stay 169.254.128.2
    uvicorn --factory fastapi_lifespan:make_app                   # the robot in $ROS_MASTER_URI

A number that is not one, or is too large, is answered with 422 by FastAPI before anything is sent to a robot.
No route waits for the end of a drive, and a stop has threads of its own: FastAPI's may all be busy. Whoever
reaches this server can drive: for other computers it needs a log-in and https, as `woosh web` has.
"""

import argparse
import asyncio
import itertools
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, asynccontextmanager
from typing import Annotated, Any

from fastapi import FastAPI, HTTPException, Query, Request
from fastapi.responses import JSONResponse

from rosproto import RosError
from woosh_pure import Chassis, MotionRefused, Outcome, SimulatedChassis
from woosh_pure.language import said
from woosh_pure.motion import StepHandle

Metres = Annotated[float, Query(ge=-10.0, le=10.0, allow_inf_nan=False, description="negative: backward")]


def make_app(master_uri: str | None = None) -> FastAPI:
    """None is the robot in $ROS_MASTER_URI. A factory: uvicorn calls it in the process that serves."""
    stops = ThreadPoolExecutor(8, "stop")
    goals: dict[int, dict[str, Any]] = {}
    handles: dict[int, StepHandle] = {}  # of the drives under way
    numbers = itertools.count(1)
    link = {"connected": False}

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        with Chassis(master_uri) as chassis:  # leaving it cancels what is under way
            app.state.chassis = chassis
            chassis.on_connection(lambda connected: link.update(connected=connected))
            yield
        stops.shutdown(wait=False)

    app = FastAPI(title="My robot", lifespan=lifespan)

    @app.middleware("http")
    async def own_pages_only(request: Request, call_next: Any) -> Any:
        """Pages of other sites may stop the robot, and nothing else."""
        origin, own = request.headers.get("origin"), str(request.base_url).rstrip("/")
        if request.method == "POST" and request.url.path != "/stop" and origin not in (None, own):
            return JSONResponse({"detail": f"pages of {origin} may not drive"}, 403)
        return await call_next(request)

    @app.get("/status")
    def status() -> dict[str, Any]:  # not `async def`: FastAPI gives it a thread
        chassis: Chassis = app.state.chassis
        battery = chassis.battery.latest  # never waits; None until something was heard
        percent = None if battery is None else battery.percent
        return {"percent": percent, **link, "ready": chassis.readiness().sentence()}

    @app.post("/move", status_code=202)
    def move(metres: Metres) -> dict[str, Any]:
        """Begin a move; its end is at /goals/NUMBER."""
        handle = app.state.chassis.move(metres)
        number = next(numbers)
        goals[number] = {"number": number, "done": False, "what": said(handle.description)}

        def done(outcome: Outcome) -> None:
            ended = {"done": True, "arrived": bool(outcome), "text": outcome.sentence()}
            goals[number] = {**goals[number], **ended}
            del handles[number]

        handles[number] = handle
        handle.on_done(done)  # called in a thread of its own
        return goals[number]

    @app.get("/goals/{number}")
    async def goal(number: int) -> dict[str, Any]:
        if number not in goals:
            raise HTTPException(404, f"there is no goal {number}")
        handle = handles.get(number)
        progress = {"metres_left": handle.progress.metres_left} if handle else {}  # never waits
        return {**goals[number], **progress}

    @app.post("/stop")
    async def stop() -> dict[str, Any]:
        chassis: Chassis = app.state.chassis
        loop = asyncio.get_running_loop()
        report = await loop.run_in_executor(stops, lambda: chassis.stop(everything=True))
        return {"stands_still": report.standing, "text": report.sentence()}

    @app.exception_handler(RosError)
    async def failed(_: Request, error: RosError) -> JSONResponse:
        return JSONResponse({"detail": said(error)}, 409 if isinstance(error, MotionRefused) else 503)

    return app


def main() -> None:
    parser = argparse.ArgumentParser(description="An API for a robot.")
    parser.add_argument("address", nargs="?", help="of the robot; without it one is simulated")
    parser.add_argument("--stay", action="store_true", help="serve until Ctrl-C, not only some requests")
    parser.add_argument("--port", type=int, default=8000)
    args = parser.parse_args()
    with ExitStack() as stack:
        address = args.address or stack.enter_context(SimulatedChassis(speed=4, full_graph=False)).master_uri
        app = make_app(address)
        if args.stay:
            import uvicorn

            uvicorn.run(app, host="127.0.0.1", port=args.port)
            return
        from fastapi.testclient import TestClient

        page = stack.enter_context(TestClient(app))
        print(page.post("/move?metres=far").status_code, page.post("/move?metres=0.2").status_code)
        app.state.chassis.battery.wait(timeout=5, new=False)
        print(page.post("/stop").status_code, page.get("/status").json())


if __name__ == "__main__":
    main()
