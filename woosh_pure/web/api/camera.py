"""GET camera/color.jpg and camera/depth.jpg, or .png: one picture, for which the camera is subscribed."""

from __future__ import annotations

from typing import Any, Literal

from fastapi import APIRouter, Query, Request, Response

from woosh_pure.web.api.dependencies import PROBLEMS, robot_of
from woosh_pure.web.camera import jpeg_of, png_of

__all__ = ["router"]

router = APIRouter(tags=["camera"], responses=PROBLEMS)
_PICTURE: dict[int | str, dict[str, Any]] = {
    200: {"content": {"image/jpeg": {}, "image/png": {}}, "description": "depth: near is bright"}
}


def get_picture(
    source: Literal["color", "depth"],
    form: Literal["jpg", "png"],
    request: Request,
    width: int = Query(640, ge=16, le=4096, description="of a JPEG, at most"),
) -> Response:
    """One picture. Waits for it for up to three seconds."""
    image = robot_of(request).cameras[source].picture()
    if form == "png":
        return Response(png_of(image), media_type="image/png")
    return Response(jpeg_of(image, width), media_type="image/jpeg")


router.add_api_route("/camera/{source}.{form}", get_picture, response_class=Response, responses=_PICTURE)
