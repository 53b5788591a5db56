"""GET map, map.png, map.yaml, plan, costmap.png."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from fastapi import APIRouter, Request, Response

from rosproto.numeric import encode_png
from woosh_pure.maps.gridmap_message import grid_from_message
from woosh_pure.web import models
from woosh_pure.web.api.dependencies import PROBLEMS, robot_of
from woosh_pure.web.live import robot_state
from woosh_pure.web.live.costmap import TOPIC
from woosh_pure.web.problems import Problem

__all__ = ["router"]

router = APIRouter(tags=["map"], responses=PROBLEMS)
_PNG: dict[int | str, dict[str, Any]] = {
    200: {"content": {"image/png": {}}, "description": "a picture, north up"}
}
_YAML: dict[int | str, dict[str, Any]] = {
    200: {"content": {"application/yaml": {}}, "description": "map_server's"}
}


def get_map(request: Request) -> dict[str, Any]:
    """Size, resolution and origin of the map."""
    return robot_of(request).map.get().as_json()


def get_map_png(request: Request) -> Response:
    """The map as PNG, north up: white is free, black is occupied, grey is not known."""
    known = robot_of(request).map.get()
    tag = f'"{known.version}"'
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers={"etag": tag})
    return Response(known.png, media_type="image/png", headers={"etag": tag, "cache-control": "no-cache"})


def get_map_yaml(request: Request) -> Response:
    """The map's YAML file for map_server; it names map.png as the image."""
    return Response(robot_of(request).map.get().yaml(), media_type="application/yaml")


def get_plan(request: Request) -> dict[str, Any]:
    """The path that is being driven; empty if there is none."""
    robot = robot_of(request)
    robot.feed("plan").open()
    return {"points": robot_state.path_points(robot)}


def get_costmap_png(request: Request) -> Response:
    """The navigation's costmap as PNG, if the navigation publishes one."""
    robot = robot_of(request)
    subscriber = robot.chassis.node.subscriber(TOPIC, "nav_msgs/OccupancyGrid", queue_size=1)
    try:
        until = time.monotonic() + 3.0
        while (message := subscriber.latest) is None and time.monotonic() < until:
            time.sleep(0.02)
    finally:
        subscriber.close()
    if message is None:
        raise Problem(
            504, f"nothing came on {TOPIC}: this chassis does not publish its costmap there", "costmap"
        )
    cells = grid_from_message(message).cells
    grey = np.where(cells < 0, 205, 254 - np.clip(cells, 0, 100).astype(np.int16) * 254 // 100)
    return Response(encode_png(grey.astype(np.uint8)[::-1]), media_type="image/png")


router.add_api_route("/map", get_map, response_model=models.MapFacts)
router.add_api_route("/map.png", get_map_png, response_class=Response, responses=_PNG)
router.add_api_route("/map.yaml", get_map_yaml, response_class=Response, responses=_YAML)
router.add_api_route("/plan", get_plan, response_model=models.Points)
router.add_api_route("/costmap.png", get_costmap_png, response_class=Response, responses=_PNG)
