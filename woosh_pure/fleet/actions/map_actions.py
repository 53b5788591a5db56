"""downloadMap, enableMap, deleteMap (6.7, 6.8.1)."""

from __future__ import annotations

from woosh_pure.errors import ChassisError
from woosh_pure.fleet.actions.map_archive import fetch, unpack
from woosh_pure.fleet.actions.map_store import MapStore
from woosh_pure.fleet.actions.predefined import predefined
from woosh_pure.fleet.actions.task import Handler, Task
from woosh_pure.fleet.order.actions import Ability

__all__ = ["map_actions"]

_POSE_SECONDS = 10.0


def map_actions(maps: MapStore) -> dict[str, tuple[Ability, Handler]]:
    """The three actions, on a vehicle's maps."""

    def download(task: Task) -> str:
        given = {key: str(value) for key, value in task.parameters.items()}
        name, version = given["mapId"], given["mapVersion"]
        if maps.find(name, version) is not None:
            raise ChassisError(f"map {name} {version} is on the vehicle already; delete it first")
        data = fetch(given["mapDownloadLink"], task.cancelled.is_set, given.get("mapHash", ""))
        grid = unpack(data)
        maps.add(name, version, grid)
        return f"{grid.width} x {grid.height} cells of {grid.resolution:g} m"

    def enable(task: Task) -> str:
        name, version = str(task.parameters["mapId"]), str(task.parameters["mapVersion"])
        if maps.find(name, version) is None:
            raise ChassisError(f"map {name} {version} is not on the vehicle; download it first")
        if name == maps.active:
            maps.use(task.chassis, name, version, task.chassis.pose.wait(_POSE_SECONDS, new=False))
        maps.enable(name, version)
        return "in use" if name == maps.active else "enabled; initPosition takes the robot there"

    def delete(task: Task) -> str:
        maps.delete(str(task.parameters["mapId"]), str(task.parameters["mapVersion"]))
        return ""

    return {
        "downloadMap": (
            predefined("downloadMap", description="Fetches a map; it is DISABLED at first."),
            download,
        ),
        "enableMap": (predefined("enableMap", still=True, description="Uses this version of a map."), enable),
        "deleteMap": (predefined("deleteMap", description="Deletes a map that is DISABLED."), delete),
    }
