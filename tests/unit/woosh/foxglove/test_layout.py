"""The layout has the names that the viewers read: what they do not know they leave out in silence.

The names are Lichtblick 1.28's (its `suite-base`: `panels`, `ThreeDeeRender/IRenderer`, `types` of each panel);
Foxglove has the same, but for the title of a panel.
"""

from __future__ import annotations

from typing import Any

import pytest

from msgdefs.geometry_msgs.msg import PoseWithCovarianceStamped
from msgdefs.nav_msgs.msg import OccupancyGrid, Path
from msgdefs.sensor_msgs.msg import LaserScan, PointCloud2
from msgdefs.visualization_msgs.msg import MarkerArray
from woosh_pure.foxglove import chassis_layout
from woosh_pure.foxglove.chassis_topics import MAP, OVERLAY
from woosh_pure.interface.table import row

TITLES = {"foxglovePanelTitle", "lichtblickPanelTitle"}
LAYOUT = {"configById", "layout", "globalVariables", "userNodes", "playbackConfig"}
SCENE = {
    "cameraState", "followMode", "followTf", "scene", "publish", "transforms", "topics", "layers", "imageMode",
}  # fmt: skip
PANELS = {
    "3D": SCENE,
    "Image": SCENE,
    "Gauge": {"colorMap", "colorMode", "gradient", "maxValue", "minValue", "path", "reverse"},
    "RawMessages": {
        "diffEnabled", "diffMethod", "diffTopicPath", "expansion", "showFullMessageForDiff", "topicPath", "fontSize",
    },
    "Plot": {
        "paths", "minXValue", "maxXValue", "minYValue", "maxYValue", "showLegend", "legendDisplay",
        "showPlotValuesInLegend", "showXAxisLabels", "showYAxisLabels", "isSynced", "xAxisVal", "xAxisPath",
        "xAxisLabel", "yAxisLabel", "followingViewWidth", "sidebarDimension",
    },
}  # fmt: skip
CAMERA = {
    "distance", "perspective", "phi", "target", "targetOffset", "targetOrientation", "thetaOffset", "fovy", "near",
    "far",
}  # fmt: skip
LINE = {"value", "enabled", "color", "label", "timestampMethod", "showLine", "lineSize"}
BASE = {"visible", "frameLocked"}
POINTS = BASE | {
    "pointSize", "pointShape", "decayTime", "colorMode", "flatColor", "colorField", "gradient", "colorMap",
    "explicitAlpha", "minValue", "maxValue",
}  # fmt: skip
DRAWN = {
    LaserScan: POINTS,
    PointCloud2: POINTS,
    OccupancyGrid: BASE
    | {"colorMode", "minColor", "maxColor", "unknownColor", "invalidColor", "alpha"},
    Path: BASE | {"type", "axisScale", "arrowScale", "lineWidth", "gradient"},
    PoseWithCovarianceStamped: BASE
    | {"type", "axisScale", "arrowScale", "color", "showCovariance", "covarianceColor"},
    MarkerArray: BASE | {"showOutlines", "color", "selectedIdVariable", "namespaces"},
}  # fmt: skip
GRID = BASE | {
    "label", "instanceId", "layerId", "frameId", "size", "divisions", "lineWidth", "color", "position", "rotation",
    "order",
}  # fmt: skip
CHOICES = {
    "followMode": {"follow-pose", "follow-position", "follow-none"},
    "diffMethod": {"custom", "previous message"},
    "legendDisplay": {"floating", "top", "left", "none"},
    "xAxisVal": {"timestamp", "index", "custom", "currentCustom"},
    "timestampMethod": {"receiveTime", "headerStamp"},
    "pointShape": {"circle", "square"},
}


@pytest.fixture(scope="module")
def panels() -> dict[str, dict[str, Any]]:
    made: dict[str, dict[str, Any]] = chassis_layout()["configById"]
    return made


def test_the_file(panels: dict[str, dict[str, Any]]) -> None:
    """What an import asks for, and panels by their kind."""
    made = chassis_layout()
    assert made.keys() <= LAYOUT
    for name in ("configById", "globalVariables", "userNodes", "playbackConfig", "layout"):
        assert isinstance(made[name], dict)
    assert isinstance(made["playbackConfig"]["speed"], (int, float))
    for name, config in panels.items():
        kind, mark, _ = name.partition("!")
        assert mark
        assert config.keys() - TITLES <= PANELS[kind], name
        assert config.keys() >= TITLES, name


def test_what_is_chosen_exists(panels: dict[str, dict[str, Any]]) -> None:
    """Words of which there are a few."""
    seen = set()

    def look(value: Any) -> None:
        if isinstance(value, dict):
            for name, inner in value.items():
                if name in CHOICES:
                    assert inner in CHOICES[name], name
                    seen.add(name)
                look(inner)
        elif isinstance(value, list):
            for inner in value:
                look(inner)

    look(panels)
    assert len(seen) >= 5
    gauge = panels["Gauge!battery"]
    assert gauge["colorMode"] in ("colormap", "gradient")
    assert gauge["colorMap"] in ("red-yellow-green", "rainbow", "turbo")


def test_the_scene(panels: dict[str, dict[str, Any]]) -> None:
    """The camera, the grid, and each topic by what is drawn for its type."""
    scene = panels["3D!woosh"]
    for name in ("3D!woosh", "Image!camera"):
        assert panels[name]["cameraState"].keys() <= CAMERA
    (grid,) = scene["layers"].values()
    assert grid["layerId"] == "foxglove.Grid"
    assert grid.keys() <= GRID
    own = {MAP: OccupancyGrid, OVERLAY: MarkerArray}
    by_type = {kind._type: names for kind, names in DRAWN.items()}
    for topic, settings in scene["topics"].items():
        kind = own[topic]._type if topic in own else row(topic).type
        assert settings.keys() <= by_type[kind], topic
        if kind in ("nav_msgs/Path", "geometry_msgs/PoseWithCovarianceStamped"):
            assert settings["type"] in {"axis", "arrow"} | ({"line"} if kind == "nav_msgs/Path" else set())
        if "colorMode" in settings:
            assert settings["colorMode"] in ("flat", "gradient", "colormap", "rgb", "rgba")
            assert "colorField" in settings, "without it the colours are the viewer's own choice"
    for name in ("Plot!velocity", "Plot!battery"):
        for line in panels[name]["paths"]:
            assert line.keys() <= LINE
