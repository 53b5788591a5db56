"""FastAPI routes over one Chassis that lives as long as the server (`pip install fastapi uvicorn`)."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI  # type: ignore[import-not-found,unused-ignore]

from woosh_pure import Chassis, SimulatedChassis


def make_app(master_uri: str | None = None) -> FastAPI:
    """None is the master in $ROS_MASTER_URI. A factory: uvicorn calls it in the process that serves."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        with Chassis(master_uri) as chassis:  # opening does not wait for the network
            app.state.chassis = chassis
            yield

    def battery() -> dict[
        str, float
    ]:  # not `async def`: FastAPI gives it a thread, where waiting harms nobody
        return {"percent": app.state.chassis.battery.wait(timeout=5, new=False).percent}

    def move(metres: float) -> dict[str, bool]:
        app.state.chassis.move(metres).wait(timeout=30)  # raises unless it arrived
        return {"arrived": True}

    app = FastAPI(lifespan=lifespan)
    app.add_api_route("/battery", battery)
    app.add_api_route("/move", move, methods=["POST"])
    return app


if __name__ == "__main__":
    from fastapi.testclient import TestClient  # type: ignore[import-not-found,unused-ignore]

    # In production: uvicorn --factory fastapi_lifespan:make_app
    with SimulatedChassis(speed=4, full_graph=False) as sim, TestClient(make_app(sim.master_uri)) as page:
        print(page.get("/battery").json(), page.post("/move?metres=0.2").json())
