"""A layout of a viewer for the chassis: import it in Foxglove or Lichtblick (Layouts, Import from file).

The names of topics come from the interface table.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

from rosproto.files import save_file
from woosh_pure.foxglove.chassis_topics import MAP, OVERLAY
from woosh_pure.interface.table import find

__all__ = ["chassis_layout", "write_layout"]

PLAN = "/move_base/global_plan"


def chassis_layout() -> dict[str, object]:
    """The layout: a 3-D view with map, scan, path, pose and overlay; camera; battery and state; plots."""
    scan, camera = find("scan").name, find("camera").name
    battery, status = find("battery").name, find("status").name
    velocity, pose = find("velocity").name, find("localization").name
    panels: dict[str, dict[str, object]] = {
        "3D!woosh": _three_d(
            {
                MAP: {"visible": True},
                OVERLAY: {"visible": True},
                scan: {
                    "visible": True,
                    "pointSize": 6,
                    # Without a field the viewer overrides all of this and colours by intensity.
                    "colorField": "intensity",
                    "colorMode": "flat",
                    "flatColor": "#ff5252ff",
                },
                PLAN: {
                    "visible": True,
                    "type": "line",
                    "lineWidth": 0.05,
                    "gradient": ["#40c4ffff", "#40c4ffff"],
                },
                pose: {
                    "visible": True,
                    "type": "arrow",
                    "color": "#7c4dffff",
                    "arrowScale": [0.8, 0.12, 0.12],
                },
                find("obstacle_points").name: {"visible": False},
            }
        ),
        "Image!camera": {
            "cameraState": _camera(),
            "scene": {"transforms": {"enablePreloading": True}},
            "imageMode": {"imageTopic": camera},
            **_title("Camera"),
        },
        "Gauge!battery": {
            "path": f"{battery}.batteryPercentage",
            "minValue": 0,
            "maxValue": 100,
            "colorMap": "red-yellow-green",
            "colorMode": "colormap",
            "gradient": ["#0000ff", "#ff00ff"],
            "reverse": False,
            **_title("Battery, %"),
        },
        "RawMessages!status": {
            "topicPath": status,
            "diffEnabled": False,
            "diffMethod": "custom",
            "diffTopicPath": "",
            "showFullMessageForDiff": False,
            **_title("State and task"),
        },
        "Plot!velocity": _plot(
            "Velocity", (f"{velocity}.linear.x", "m/s"), (f"{velocity}.angular.z", "rad/s")
        ),
        "Plot!battery": _plot(
            "Battery", (f"{battery}.batteryVoltage", "V"), (f"{battery}.batteryCurrent", "A")
        ),
    }
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": {
            "direction": "row",
            "splitPercentage": 62,
            "first": "3D!woosh",
            "second": {
                "direction": "column",
                "splitPercentage": 38,
                "first": "Image!camera",
                "second": {
                    "direction": "column",
                    "splitPercentage": 45,
                    "first": {
                        "direction": "row",
                        "splitPercentage": 45,
                        "first": "Gauge!battery",
                        "second": "RawMessages!status",
                    },
                    "second": {
                        "direction": "row",
                        "splitPercentage": 50,
                        "first": "Plot!velocity",
                        "second": "Plot!battery",
                    },
                },
            },
        },
    }


def _title(text: str) -> dict[str, str]:
    """A panel's title, under the key of each of the two viewers."""
    return {"foxglovePanelTitle": text, "lichtblickPanelTitle": text}


def _camera() -> dict[str, object]:
    return {
        "distance": 16,
        "perspective": True,
        "phi": 40,
        "target": [0, 0, 0],
        "targetOffset": [3, 0, 0],
        "targetOrientation": [0, 0, 0, 1],
        "thetaOffset": 90,
        "fovy": 45,
        "near": 0.5,
        "far": 5000,
    }


def _three_d(topics: dict[str, dict[str, object]]) -> dict[str, object]:
    return {
        "cameraState": _camera(),
        "followMode": "follow-none",
        "followTf": "map",
        "scene": {"transforms": {"showLabel": False, "axisScale": 0.3, "enablePreloading": True}},
        "transforms": {},
        "topics": topics,
        "layers": {
            "grid": {
                "visible": True,
                "frameLocked": True,
                "label": "Grid",
                "instanceId": "grid",
                "layerId": "foxglove.Grid",
                "size": 40,
                "divisions": 40,
                "lineWidth": 1,
                "color": "#248eff44",
                "position": [0, 0, 0],
                "rotation": [0, 0, 0],
                "order": 1,
            }
        },
        "imageMode": {},
        **_title("Chassis"),
    }


def _plot(title: str, *lines: tuple[str, str]) -> dict[str, object]:
    return {
        "paths": [
            {"value": path, "enabled": True, "timestampMethod": "receiveTime", "label": label}
            for path, label in lines
        ],
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": True,
        "isSynced": True,
        "xAxisVal": "timestamp",
        "sidebarDimension": 240,
        "followingViewWidth": 60,
        **_title(title),
    }


def write_layout(path: str | os.PathLike[str]) -> Path:
    """Write the layout to a file; if writing is interrupted, the old file stays.

    Raises:
        OSError: The file cannot be written.
    """
    file = Path(path)
    save_file(file, (json.dumps(chassis_layout(), indent=2) + "\n").encode())
    return file
